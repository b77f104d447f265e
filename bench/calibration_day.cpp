/// MAP fit on worn directions, and a simulated day of 0 to 50 degC with hysteresis under each forgetting policy.
#include <cstdio>

#include "bench/calibration_tables.h"
#include "calib_online/online_calibrator.h"
#include "calib_online/points_fit.h"

namespace stillpoint::bench {
namespace {

constexpr double kG = kStandardGravity_mps2;
constexpr double kMg = 1e-3 * kG;

// ---- worn directions
// ---------------------------------------------------------------------------------------------------

struct Truth {
  Mat3 K;
  Vec3 o;
};
/// A sensor drawn from the prior: 2 % scale, 1 % shear, 40 mg bias.
Truth draw(Random& random) {
  Truth t{Mat3::Identity(), random.normal3(0.04)};
  for (int i = 0; i < 3; ++i) t.K(i, i) += random.normal(0.02);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < i; ++j) t.K(i, j) = t.K(j, i) = random.normal(0.01 / 2);
  return t;
}
double error_mg(const Truth& t, const calib::Ellipsoid& e) {
  std::vector<double> out;
  const Mat3 inv = t.K.inverse();
  for (const Vec3& u : even_directions(300)) out.push_back(1000 * ((e.K * (inv * u + t.o - e.centre)).norm() - 1));
  return rms(out);
}

// ---- the day
// -----------------------------------------------------------------------------------------------------------

/// The sensor's parameters of data-sheet size; temperature with a lag of 20 minutes for the hysteresis.
struct DaySensor {
  Vec3 b0, b1, b2, hysteresis, g0, g1, g2, g_hysteresis;
  Mat3 M0, M1;
  explicit DaySensor(Random& r)
      : b0(r.normal3(5 * kMg)),
        b1(r.normal3(0.8 * kMg)),
        b2(r.normal3(5 * kMg)),
        hysteresis(r.normal3(0.15 * kMg)),
        g0(r.normal3(0.3 * kRadPerDeg)),
        g1(r.normal3(0.03 * kRadPerDeg)),
        g2(r.normal3(0.1 * kRadPerDeg)),
        g_hysteresis(r.normal3(0.002 * kRadPerDeg)) {
    for (int i = 0; i < 9; ++i) M0(i / 3, i % 3) = r.normal(0.002);
    for (int i = 0; i < 9; ++i) M1(i / 3, i % 3) = r.normal(0.003);
    M0 = (0.5 * (M0 + M0.transpose())).eval();  // a rotation of the accelerometer is not visible in its norm
    M1 = (0.5 * (M1 + M1.transpose())).eval();
  }
  Vec3 acc(const Vec3& u, double T, double lag) const {
    const double t = (T - 25) / 25;
    return (Mat3::Identity() + M0 + t * M1) * u + b0 + (T - 25) * b1 + t * t * b2 + (T - lag) * hysteresis;
  }
  Vec3 gyr_bias(double T, double lag) const {
    const double t = (T - 25) / 25;
    return g0 + (T - 25) * g1 + t * t * g2 + (T - lag) * g_hysteresis;
  }
};

double temperature(double t_s) {
  const double h = t_s / 3600.0;
  // A slow swing over the day and an excursion of three hours (indoors, in the sun, in the cold).
  return std::clamp(25 + 21 * std::sin(2 * 3.14159265 * h / 24.0) + 5 * std::sin(2 * 3.14159265 * h / 3.1), 0.0, 50.0);
}

/// Half the width of the loop that a lag of 20 minutes makes of the day's swings, K: the amplitude of T - lag.
double loop_K() {
  std::vector<double> apart;
  double lag = temperature(0);
  for (int minute = 0; minute < 1440; ++minute) {
    const double T = temperature(60.0 * minute);
    lag += (T - lag) * 60.0 / 1200.0;
    apart.push_back(T - lag);
  }
  return std::sqrt(2.0) * rms(apart);
}

struct Policy {
  const char* name;
  calib::OnlineCalibratorParams params;
};

/// The prior is that of the sensors drawn above, as a data sheet would give it.
calib::OnlineCalibratorParams day_params(const char* model, double keep) {
  calib::OnlineCalibratorParams p;
  p.temperature_model = model;
  p.temperature_cells.keep = keep;
  p.accelerometer.bias_sd_mps2 = 5 * kMg;
  p.accelerometer.scale_sd = 0.002;
  p.accelerometer.shear_sd = 0.002 * std::sqrt(2.0);  // an angle between two axes is the sum of two elements
  p.accelerometer.bias_curvature_sd_mps2 = 5 * kMg;
  p.accelerometer.matrix_per_25K_sd = 0.003;
  p.accelerometer.bias_per_K_sd_mps2 = 0.8 * kMg;
  p.accelerometer.wander_sd_mps2 = 0.15 * kMg * loop_K();
  p.accelerometer.norm_floor_mps2 = 0.3 * kMg;  // as much again as the windows' noise
  p.gyroscope.bias_sd_radps = 0.3 * kRadPerDeg;
  if (std::string(model) == "none") {
    // Without a temperature model the prior is the factory calibration's error at any temperature.
    p.accelerometer.bias_sd_mps2 = 11 * kMg;
    p.accelerometer.scale_sd = p.accelerometer.shear_sd = 0.004;
  }
  return p;
}

struct DayResult {
  double acc_mg[2]{}, gyr_dps[2]{}, factory_mg = 0, factory_dps = 0, last_window_dps = 0, worse = 0, predicted_mg = 0;
};

DayResult day(const calib::OnlineCalibratorParams& params, unsigned seed) {
  Random random(seed);
  const DaySensor sensor(random);
  calib::OnlineCalibrator calibrator(params, CalibrationSnapshot{});
  std::vector<double> acc[3], gyr[3], factory, factory_gyr, last_gyr, predicted;
  int minutes = 0, worse = 0;
  double lag = temperature(0);
  Vec3 direction = Vec3::UnitZ(), last_rate = Vec3::Zero();
  const auto directions = even_directions(60);
  auto worn = worn_directions(random, 20000);
  std::size_t next = 0;
  bool moved = true;
  for (int minute = 0; minute < 3 * 1440; ++minute) {
    const double t_s = 60.0 * minute, T = temperature(t_s);
    lag += (T - lag) * 60.0 / 1200.0;
    // Every minute ends in rest with one chance in two, in a new posture with one in five.
    if (random.uniform(0, 1) < 0.2) direction = worn[next++ % worn.size()], moved = true;
    if (random.uniform(0, 1) < 0.5) {
      calib::Window w;
      w.t_start_ns = static_cast<std::int64_t>((t_s + 58.0) * 1e9);
      w.t_end_ns = static_cast<std::int64_t>((t_s + 60.0) * 1e9);
      w.has = kAcc | kGyr | kTemp;
      w.temp_degC = T;
      const bool pushed = random.uniform(0, 1) < 0.03;  // a steady acceleration that no statistic of the window can see
      w.acc_mps2 = array(Vec3(sensor.acc(kG * direction, T, lag) + random.normal3(0.3 * kMg) +
                              (pushed ? random.normal3(8 * kMg) : Vec3(Vec3::Zero()))));
      w.acc_cov = array(Mat3(std::pow(0.3 * kMg, 2) * Mat3::Identity()));
      last_rate = sensor.gyr_bias(T, lag) + random.normal3(0.005 * kRadPerDeg) +
                  (random.uniform(0, 1) < 0.05 ? random.normal3(0.4 * kRadPerDeg) : Vec3(Vec3::Zero()));
      w.gyr_radps = array(last_rate);
      w.gyr_cov = array(Mat3(std::pow(0.005 * kRadPerDeg, 2) * Mat3::Identity()));
      // Gravity bounds a turn about the level axes; the field, less well, one about the vertical.
      w.turn_cov = array(Mat3(std::pow(0.01 * kRadPerDeg, 2) * Mat3::Identity() +
                              std::pow(0.05 * kRadPerDeg, 2) * direction * direction.transpose()));
      w.moved = moved;
      moved = false;
      calibrator.absorb(w);
    }
    const CalibrationSnapshot& s = calibrator.snapshot();
    if (s.version == 0) continue;  // before the first window there is nothing to judge
    std::vector<double> e, f;
    for (const Vec3& u : directions) {
      const Array3 y = array(sensor.acc(kG * u, T, lag));
      e.push_back((s.acc.apply(y, T).norm() - kG) / kMg);
      f.push_back((vec(y).norm() - kG) / kMg);
    }
    const int d = minute / 1440;
    acc[d].push_back(rms(e));
    gyr[d].push_back((s.gyr.bias_at(T) - sensor.gyr_bias(T, lag)).norm() / std::sqrt(3.0) * kDegPerRad);
    if (d == 0) {
      factory.push_back(rms(f));
      factory_gyr.push_back(sensor.gyr_bias(T, lag).norm() / std::sqrt(3.0) * kDegPerRad);
      last_gyr.push_back((last_rate - sensor.gyr_bias(T, lag)).norm() / std::sqrt(3.0) * kDegPerRad);
      worse += rms(e) > rms(f) + 0.5;
      ++minutes;
    }
    if (d == 2) predicted.push_back(s.acc.norm_sd / kMg);
  }
  DayResult r;
  r.acc_mg[0] = rms(acc[0]);
  r.acc_mg[1] = rms(acc[2]);
  r.gyr_dps[0] = rms(gyr[0]);
  r.gyr_dps[1] = rms(gyr[2]);
  r.factory_mg = rms(factory);
  r.factory_dps = rms(factory_gyr);
  r.last_window_dps = rms(last_gyr);
  r.worse = 100.0 * worse / minutes;
  r.predicted_mg = rms(predicted);
  return r;
}

}  // namespace

Figures worn_and_adjusted() {
  Figures figures;
  std::printf(
      "\n== Worn directions, MAP fit ==\nsensor drawn from the prior (2 %% scale, 1 %% shear, 40 mg bias), noise 0.6 "
      "%%, 40 seeds; mg rms over EVEN directions\n");
  std::printf("%8s %8s %10s %16s %10s %10s\n", "windows", "MAP", "predicted", "predicted/actual", "LinAuto", "Mgn");
  for (const int n : {12, 20, 150, 270, 1000}) {
    std::vector<double> map, predicted, lin, mgn;
    int mgn_failed = 0;
    for (unsigned seed = 0; seed < 40; ++seed) {
      Random random(500 + seed);
      const Truth t = draw(random);
      const Mat3 inv = t.K.inverse();
      calib::Moments m;
      const double sd = 0.006;
      for (const Vec3& u : worn_directions(random, n)) m.add(Vec3(inv * u + t.o + random.normal3(sd)));
      const Mat3 C = sd * sd * Mat3::Identity();
      const auto fit = calib::map_fit(m.adjusted(C), sd, {0.02, 0.01, 0.04});
      map.push_back(error_mg(t, fit.ellipsoid));
      predicted.push_back(1000 * fit.norm_sd);
      const auto l = calib::lin_auto(m);
      if (l.status == calib::FitStatus::kOk)
        lin.push_back(error_mg(t, {l.centre, Mat3(l.radii.cwiseInverse().asDiagonal())}));
      const auto g = calib::general_fit(m);
      if (g.status == calib::FitStatus::kOk)
        mgn.push_back(error_mg(t, g.ellipsoid));
      else
        ++mgn_failed;
    }
    std::printf("%8d %8.1f %10.1f %16.2f %10.1f %10.1f (%d fail)\n", n, rms(map), rms(predicted),
                rms(predicted) / rms(map), quantile(lin, .5), quantile(mgn, .5), mgn_failed);
    figures["map_mg_" + std::to_string(n)] = rms(map);
    figures["map_predicted_over_actual_" + std::to_string(n)] = rms(predicted) / rms(map);
  }
  return figures;
}

Figures simulated_day() {
  constexpr unsigned kSeeds = 60;
  std::printf(
      "\n== Simulated day, 0-50 degC, hysteresis with a lag of 20 min; %u seeds; rms over minutes and seeds "
      "(accelerometer: over even directions) +- the standard error of day 1 ==\n",
      kSeeds);
  std::printf("%-38s %17s %9s %9s %9s %8s %9s\n", "policy", "acc d1 mg", "acc d3 mg", "gyr d1 ", "gyr d3 ", "worse %",
              "pred/act");
  const Policy policies[] = {{"polynomial", day_params("polynomial", 1.0)},
                             {"cells", day_params("cells", 0.998)},
                             {"plain", day_params("none", 1.0)},
                             {"forgetting of 1 h", day_params("none", 1.0 - 1.0 / 30.0)}};
  Figures figures;
  double factory = 0, factory_dps = 0, last = 0;
  for (const Policy& policy : policies) {
    std::vector<double> a1, a1_squared, a3, g1, g3, worse, predicted, f, fg, lw;
    for (unsigned seed = 0; seed < kSeeds; ++seed) {
      const DayResult r = day(policy.params, 900 + seed);
      a1.push_back(r.acc_mg[0]);
      a1_squared.push_back(r.acc_mg[0] * r.acc_mg[0]);
      a3.push_back(r.acc_mg[1]);
      g1.push_back(r.gyr_dps[0]);
      g3.push_back(r.gyr_dps[1]);
      worse.push_back(r.worse);
      predicted.push_back(r.predicted_mg);
      f.push_back(r.factory_mg);
      fg.push_back(r.factory_dps);
      lw.push_back(r.last_window_dps);
    }
    factory = rms(f);
    factory_dps = rms(fg);
    last = rms(lw);
    const double error = sd(a1_squared) / std::sqrt(double(kSeeds)) / (2.0 * rms(a1));
    std::printf("%-38s %9.2f +- %.2f %9.2f %9.4f %9.4f %8.2f %9.2f\n", policy.name, rms(a1), error, rms(a3), rms(g1),
                rms(g3), mean(worse), rms(predicted) / rms(a3));
    const std::string name = policy.name;
    figures[name + ".acc_day1_mg"] = rms(a1);
    figures[name + ".acc_day3_mg"] = rms(a3);
    figures[name + ".gyr_day1_dps"] = rms(g1);
    figures[name + ".gyr_day3_dps"] = rms(g3);
    figures[name + ".worse_percent"] = mean(worse);
    figures[name + ".predicted_over_actual"] = rms(predicted) / rms(a3);
  }
  std::printf("%-38s %9.2f %17s %9s %9.3f\n%-38s %9s %17s %9s %9.3f\n", "factory calibration", factory, "", "",
              factory_dps, "last window alone", "", "", "", last);
  std::printf(
      "polynomial: of temperature, with wander (default); cells: evidence tagged by temperature; plain: all windows "
      "and a prior\n");
  return figures;
}

}  // namespace stillpoint::bench
