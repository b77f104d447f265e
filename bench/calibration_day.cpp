/// A simulated day of 0 to 50 degC with hysteresis under each forgetting policy.
#include <cstdio>
#include <optional>
#include <utility>

#include "bench/calibration_tables.h"
#include "calib_online/online_calibrator.h"

namespace stillpoint::bench {
namespace {

constexpr double kG = kStandardGravity_mps2;
constexpr double kMg = 1e-3 * kG;

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

constexpr int kMinutesOfADay = 1440;

/// A wearer's minutes: the temperature with its lag, and the windows of rest they bring.
class Wear {
 public:
  explicit Wear(unsigned seed) : random_(seed), sensor_(random_), worn_(worn_directions(random_, 20000)) {}

  /// One minute on. It ends in rest with one chance in two, in a new posture with one in five.
  std::optional<calib::Window> minute(int index) {
    const double t_s = 60.0 * index;
    temp_degC_ = temperature(t_s);
    lag_degC_ += (temp_degC_ - lag_degC_) * 60.0 / 1200.0;
    if (random_.uniform(0, 1) < 0.2) direction_ = worn_[next_++ % worn_.size()], moved_ = true;
    if (random_.uniform(0, 1) < 0.5) return window(t_s);
    return std::nullopt;
  }
  [[nodiscard]] double temp_degC() const { return temp_degC_; }
  /// What the accelerometer reads now under the specific force `f_mps2`, without noise.
  [[nodiscard]] Vec3 acc_mps2(const Vec3& f_mps2) const { return sensor_.acc(f_mps2, temp_degC_, lag_degC_); }
  [[nodiscard]] Vec3 gyr_bias_radps() const { return sensor_.gyr_bias(temp_degC_, lag_degC_); }
  [[nodiscard]] const Vec3& last_rate_radps() const { return last_rate_radps_; }

 private:
  calib::Window window(double t_s) {
    calib::Window w;
    w.t_start_ns = static_cast<std::int64_t>((t_s + 58.0) * 1e9);
    w.t_end_ns = static_cast<std::int64_t>((t_s + 60.0) * 1e9);
    w.has = kAcc | kGyr | kTemp;
    w.temp_degC = temp_degC_;
    const bool pushed = random_.uniform(0, 1) < 0.03;  // a steady acceleration that no statistic of the window can see
    w.acc_mps2 = array(Vec3(acc_mps2(kG * direction_) + random_.normal3(0.3 * kMg) +
                            (pushed ? random_.normal3(8 * kMg) : Vec3(Vec3::Zero()))));
    w.acc_cov = array(Mat3(std::pow(0.3 * kMg, 2) * Mat3::Identity()));
    last_rate_radps_ = gyr_bias_radps() + random_.normal3(0.005 * kRadPerDeg) +
                       (random_.uniform(0, 1) < 0.05 ? random_.normal3(0.4 * kRadPerDeg) : Vec3(Vec3::Zero()));
    w.gyr_radps = array(last_rate_radps_);
    w.gyr_cov = array(Mat3(std::pow(0.005 * kRadPerDeg, 2) * Mat3::Identity()));
    // Gravity bounds a turn about the level axes; the field, less well, one about the vertical.
    w.turn_cov = array(Mat3(std::pow(0.01 * kRadPerDeg, 2) * Mat3::Identity() +
                            std::pow(0.05 * kRadPerDeg, 2) * direction_ * direction_.transpose()));
    w.moved = std::exchange(moved_, false);
    return w;
  }

  Random random_;
  DaySensor sensor_;
  std::vector<Vec3> worn_;
  std::size_t next_ = 0;
  Vec3 direction_ = Vec3::UnitZ(), last_rate_radps_ = Vec3::Zero();
  double temp_degC_ = temperature(0), lag_degC_ = temperature(0);
  bool moved_ = true;
};

/// What the calibration leaves, minute by minute, beside what the factory's leaves.
class DayErrors {
 public:
  void add(int minute, const Wear& wear, const CalibrationSnapshot& s) {
    std::vector<double> after, before;
    for (const Vec3& u : directions_) {
      const Array3 y = array(wear.acc_mps2(kG * u));
      after.push_back((s.acc.apply(y, wear.temp_degC()).norm() - kG) / kMg);
      before.push_back((vec(y).norm() - kG) / kMg);
    }
    const int d = minute / kMinutesOfADay;
    acc_mg_[d].push_back(rms(after));
    gyr_dps_[d].push_back(dps_an_axis(s.gyr.bias_at(wear.temp_degC()) - wear.gyr_bias_radps()));
    if (d == 0) {
      factory_mg_.push_back(rms(before));
      factory_dps_.push_back(dps_an_axis(wear.gyr_bias_radps()));
      last_window_dps_.push_back(dps_an_axis(wear.last_rate_radps() - wear.gyr_bias_radps()));
      worse_ += rms(after) > rms(before) + 0.5;
    }
    if (d == 2) predicted_mg_.push_back(s.acc.norm_sd / kMg);
  }
  [[nodiscard]] DayResult result() const {
    DayResult r;
    r.acc_mg[0] = rms(acc_mg_[0]);
    r.acc_mg[1] = rms(acc_mg_[2]);
    r.gyr_dps[0] = rms(gyr_dps_[0]);
    r.gyr_dps[1] = rms(gyr_dps_[2]);
    r.factory_mg = rms(factory_mg_);
    r.factory_dps = rms(factory_dps_);
    r.last_window_dps = rms(last_window_dps_);
    r.worse = 100.0 * worse_ / static_cast<double>(factory_mg_.size());
    r.predicted_mg = rms(predicted_mg_);
    return r;
  }

 private:
  static double dps_an_axis(const Vec3& rate_radps) { return rate_radps.norm() / std::sqrt(3.0) * kDegPerRad; }

  std::vector<Vec3> directions_ = even_directions(60);
  std::vector<double> acc_mg_[3], gyr_dps_[3], factory_mg_, factory_dps_, last_window_dps_, predicted_mg_;
  int worse_ = 0;
};

DayResult day(const calib::OnlineCalibratorParams& params, unsigned seed) {
  Wear wear(seed);
  calib::OnlineCalibrator calibrator(params, CalibrationSnapshot{});
  DayErrors errors;
  for (int minute = 0; minute < 3 * kMinutesOfADay; ++minute) {
    if (const auto window = wear.minute(minute)) calibrator.absorb(*window);
    // before the first window there is nothing to judge
    if (calibrator.snapshot().version > 0) errors.add(minute, wear, calibrator.snapshot());
  }
  return errors.result();
}

/// The days of all seeds under one policy.
struct Days {
  std::vector<double> acc1_mg, acc3_mg, gyr1_dps, gyr3_dps, worse, predicted_mg, factory_mg, factory_dps,
      last_window_dps;
  void add(const DayResult& r) {
    acc1_mg.push_back(r.acc_mg[0]);
    acc3_mg.push_back(r.acc_mg[1]);
    gyr1_dps.push_back(r.gyr_dps[0]);
    gyr3_dps.push_back(r.gyr_dps[1]);
    worse.push_back(r.worse);
    predicted_mg.push_back(r.predicted_mg);
    factory_mg.push_back(r.factory_mg);
    factory_dps.push_back(r.factory_dps);
    last_window_dps.push_back(r.last_window_dps);
  }
  /// Standard error of the rms of day 1, from the scatter of its squares.
  [[nodiscard]] double error_of_day1_mg() const {
    std::vector<double> squared;
    for (const double x : acc1_mg) squared.push_back(x * x);
    return sd(squared) / std::sqrt(static_cast<double>(squared.size())) / (2.0 * rms(acc1_mg));
  }
};

void print_line(const char* name, const Days& days, Figures& figures) {
  const double over_actual = rms(days.predicted_mg) / rms(days.acc3_mg);
  std::printf("%-38s %9.2f +- %.2f %9.2f %9.4f %9.4f %8.2f %9.2f\n", name, rms(days.acc1_mg), days.error_of_day1_mg(),
              rms(days.acc3_mg), rms(days.gyr1_dps), rms(days.gyr3_dps), mean(days.worse), over_actual);
  const std::string policy = name;
  figures[policy + ".acc_day1_mg"] = rms(days.acc1_mg);
  figures[policy + ".acc_day3_mg"] = rms(days.acc3_mg);
  figures[policy + ".gyr_day1_dps"] = rms(days.gyr1_dps);
  figures[policy + ".gyr_day3_dps"] = rms(days.gyr3_dps);
  figures[policy + ".worse_percent"] = mean(days.worse);
  figures[policy + ".predicted_over_actual"] = over_actual;
}

}  // namespace

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
  Days days;
  for (const Policy& policy : policies) {
    days = {};
    for (unsigned seed = 0; seed < kSeeds; ++seed) days.add(day(policy.params, 900 + seed));
    print_line(policy.name, days, figures);
  }
  // The sensors are the same under each policy, and with them what the factory's calibration leaves.
  std::printf("%-38s %9.2f %17s %9s %9.3f\n%-38s %9s %17s %9s %9.3f\n", "factory calibration", rms(days.factory_mg), "",
              "", rms(days.factory_dps), "last window alone", "", "", "", rms(days.last_window_dps));
  std::printf(
      "polynomial: of temperature, with wander (default); cells: evidence tagged by temperature; plain: all windows "
      "and a prior\n");
  return figures;
}

}  // namespace stillpoint::bench
