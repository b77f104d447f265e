#include "diagnosis/prove/invented.h"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <random>

#include "diagnosis/prove/draw.h"
#include "diagnosis/prove/invented_law.h"
#include "io/simulated_recording.h"
#include "simulation/simulator.h"

namespace stillpoint::diag {
namespace {

using invented::Scene;

constexpr int kMostLawDraws = 60;
constexpr double kLeastOwn = 0.3;  // of its rms that bias and matrix may not take up

sim::SimulationConfig draw_sensor(Draw& draw, double duration_s) {
  sim::SimulationConfig s;
  s.rate_hz = 50.0;
  const auto triad = [&](double bias, double matrix, double noise) {
    sim::TriadConfig t;
    for (int i = 0; i < 3; ++i) {
      t.bias[i] = bias * draw.normal();
      for (int j = 0; j < 3; ++j) t.matrix(i, j) += matrix * draw.normal();
    }
    t.noise_sd = noise;
    return t;
  };
  s.accelerometer = triad(0.2, 0.01, 0.015);
  s.gyroscope = triad(0.01, 0.01, 8e-4);
  s.magnetometer = triad(5.0, 0.03, 0.25);
  s.motion = sim::MotionConfig{};
  s.motion->duration_s = duration_s;
  s.motion->rate_radps = draw.uniform(1.0, 2.0);
  s.environment.temperature.kind = draw.bits() % 2 == 0 ? "warm_up" : "activity";
  s.environment.temperature.start_degC = draw.uniform(18, 30);
  s.environment.temperature.rise_K = draw.uniform(6, 16);
  s.environment.temperature.tau_s = draw.uniform(20, 60);
  s.environment.current.kind = "steps";
  s.reference.kind = draw.bits() % 2 == 0 ? "exact" : "mocap";
  return s;
}

sim::SimulationConfig noiseless(sim::SimulationConfig s) {
  for (auto* t : {&s.accelerometer, &s.gyroscope, &s.magnetometer}) {
    (*t)->noise_sd = 0.0;
    (*t)->bias.setZero();
    (*t)->matrix.setIdentity();
  }
  s.reference.kind = "exact";
  return s;
}

/// Columns of programs that know more than the sensor: of a motor, a valve, a pump.
void add_columns(Draw& draw, io::Recording& r) {
  const double length = r.t_s(r.size() - 1) - r.t_s(0);
  for (const auto& [name, size] : {std::pair{"motor_rpm", 3000.0}, {"valve_pct", 50.0}, {"pressure_kPa", 100.0}}) {
    std::array<double, 4> rate{}, phase{};
    for (std::size_t i = 0; i < rate.size(); ++i)
      rate[i] = draw.log_uniform(1.5, 20.0) * 6.28 / length, phase[i] = draw.uniform(0, 6.28);
    auto& column = r.user_columns[name];
    for (std::size_t row = 0; row < r.size(); ++row) {
      double x = 1.0;
      for (std::size_t i = 0; i < rate.size(); ++i) x += 0.3 * std::sin(rate[i] * r.t_s(row) + phase[i]);
      column.push_back(size * x);
    }
  }
}

Scene scene_of(const io::Recording& truth, const io::Recording& told) {
  Scene s;
  const auto n = static_cast<Eigen::Index>(truth.size());
  s.t = Eigen::VectorXd(n);
  for (auto* v : {&s.w, &s.f, &s.m}) v->resize(n, 3);
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto row = static_cast<std::size_t>(i);
    s.t[i] = truth.t_s(row) - truth.t_s(0);
    s.w.row(i) = truth.gyr_radps[row], s.f.row(i) = truth.acc_mps2[row], s.m.row(i) = truth.mag_uT[row];
  }
  const auto column = [n](const std::vector<double>& x) {
    return Eigen::VectorXd(Eigen::Map<const Eigen::VectorXd>(x.data(), n));
  };
  s.scalars["T"] = invented::smooth(column(told.temp_degC), 50);
  s.scalars["I"] = column(told.current_A);
  s.scalars["V"] = column(told.supply_V);
  for (const auto& [name, x] : told.user_columns) s.scalars[name] = column(x);
  return s;
}

const Eigen::MatrixXd& own(const Scene& s, const std::string& sensor) {
  return sensor == "acc" ? s.f : sensor == "gyr" ? s.w : s.m;
}

/// Without the offset and the linear map of the true vector that fit it best.
Eigen::MatrixXd without_bias_and_matrix(const Eigen::MatrixXd& delta, const Eigen::MatrixXd& vector) {
  Eigen::MatrixXd design(delta.rows(), 4);
  design << Eigen::VectorXd::Ones(delta.rows()), vector;
  return delta - design * design.colPivHouseholderQr().solve(delta);
}

double rms(const Eigen::MatrixXd& x) { return std::sqrt(x.squaredNorm() / static_cast<double>(x.size())); }

std::vector<Vec3>& readings(io::Recording& r, const std::string& sensor) {
  return sensor == "acc" ? r.acc_mps2 : sensor == "gyr" ? r.gyr_radps : r.mag_uT;
}

const sim::TriadConfig& triad_of(const sim::SimulationConfig& s, const std::string& sensor) {
  return *(sensor == "acc" ? s.accelerometer : sensor == "gyr" ? s.gyroscope : s.magnetometer);
}

/// Readings of a noiseless sensor with these effects on the fresh motion; empty where they cannot be run there.
std::optional<io::Recording> on_fresh(const InventedCase& c, const std::vector<sim::EffectConfig>& effects) {
  sim::SimulationConfig s = noiseless(c.baseline);
  s.motion.reset();
  s.environment = {};
  s.effects.clear();
  for (const auto& e : effects)
    if (!e.id.ends_with("_drift") && !e.id.ends_with("_instability") && !e.id.ends_with("_quant") &&
        e.id != "sys_dup" && e.id != "ref_error" && e.id != "sys_jitter")
      s.effects.push_back(e);
  auto motion = sim::RecordedMotion::from(io::reference_track(c.fresh));
  if (!motion) return std::nullopt;
  sim::Simulator simulator(s, std::move(*motion), 1, io::recorded_environment(c.fresh));
  std::vector<sim::SimulatedSample> rows;
  for (sim::SimulatedSample row; simulator.next(row);) rows.push_back(row);
  return io::to_recording(rows);
}

Eigen::MatrixXd matrix_of_rows(const std::vector<Vec3>& x, Eigen::Index n) {
  Eigen::MatrixXd out(n, 3);
  for (Eigen::Index i = 0; i < n; ++i) out.row(i) = x[static_cast<std::size_t>(i)];
  return out;
}

}  // namespace

InventedCase invent(const std::string& salt, std::size_t index, bool quick) {
  Draw draw(salt + "/invented", index);
  InventedCase c;
  c.id = fmt::format("{:04}", index);
  c.clean = index % 4 == 3;
  const sim::SimulationConfig config = c.baseline = draw_sensor(draw, quick ? 60.0 : 120.0);
  const std::uint64_t seed = draw.bits(), other = draw.bits();
  c.recording = io::to_recording(sim::simulate(config, seed));
  io::Recording truth = io::to_recording(sim::simulate(noiseless(config), seed));
  c.fresh = io::to_recording(sim::simulate(noiseless(config), other));
  add_columns(draw, c.recording);
  add_columns(draw, c.fresh);
  std::random_device device;
  for (int i = 0; i < 4; ++i) c.nonce += fmt::format("{:08x}", device());
  if (c.clean) return c;
  const Scene here = scene_of(truth, c.recording), there = scene_of(c.fresh, c.fresh);
  static const std::vector<std::string> kNames{"acc", "gyr", "mag"};
  const double wanted = draw.log_uniform(0.8, 4.0);
  for (int drawn = 0; drawn < kMostLawDraws; ++drawn) {
    c.sensor = draw.one_of(kNames);
    const invented::Law law = invented::draw_law(draw, here, c.sensor == "acc" ? "f" : c.sensor == "gyr" ? "w" : "m");
    const Eigen::MatrixXd delta = law.value(here), fresh = law.value(there);
    const double kept = rms(without_bias_and_matrix(delta, own(here, c.sensor)));
    const double kept_there = rms(without_bias_and_matrix(fresh, own(there, c.sensor)));
    const bool whole = delta.allFinite() && fresh.allFinite();
    if (!whole || !(kept > kLeastOwn * rms(delta)) || !(kept_there > 0.2 * kept)) continue;
    const sim::TriadConfig& t = triad_of(config, c.sensor);
    const double scale = wanted * t.noise_sd / kept;
    auto& column = readings(c.recording, c.sensor);
    for (Eigen::Index i = 0; i < delta.rows(); ++i) {
      column[static_cast<std::size_t>(i)] += t.matrix.inverse() * (scale * Vec3(delta.row(i)));
      c.fresh_delta.emplace_back(scale * Vec3(fresh.row(i)));
    }
    c.law = law.text, c.drivers = law.drivers, c.rms_over_noise = wanted;
    return c;
  }
  c.clean = true;
  return c;
}

nlohmann::json truth_of(const InventedCase& c) {
  return {{"clean", c.clean}, {"law", c.law}, {"sensor", c.sensor}, {"drivers", c.drivers}, {"rms", c.rms_over_noise}};
}

InventedScore score_invented(const InventedCase& c, const sim::SimulationConfig& improved,
                             const nlohmann::json& answer) {
  InventedScore out;
  out.clean = c.clean;
  std::set<std::string> drivers;
  for (const auto& f : answer.value("findings", nlohmann::json::array())) {
    if (f.value("effect", "").ends_with("_quant")) continue;
    out.said.push_back(f.value("effect", ""));
    if (f.contains("law"))
      for (const auto& d : f["law"].value("drivers", std::vector<std::string>{})) drivers.insert(d);
  }
  if (c.clean) return out;
  const auto before = on_fresh(c, {}), after = on_fresh(c, improved.effects);
  if (!before || !after) return out;
  const auto n = static_cast<Eigen::Index>(std::min({before->size(), after->size(), c.fresh_delta.size()}));
  io::Recording plain = *before, with = *after;
  const Eigen::MatrixXd vector = matrix_of_rows(readings(plain, c.sensor), n);
  const Eigen::MatrixXd modelled = matrix_of_rows(readings(with, c.sensor), n) - vector;
  const Eigen::MatrixXd wanted = without_bias_and_matrix(matrix_of_rows(c.fresh_delta, n), vector);
  const Eigen::MatrixXd left = wanted - without_bias_and_matrix(modelled, vector);
  out.r2 = 1.0 - left.squaredNorm() / wanted.squaredNorm();
  out.drivers_right = drivers == c.drivers || out.r2 >= 0.95;
  return out;
}

std::string invented_table(const std::vector<InventedScore>& scores) {
  std::size_t laws = 0, clean = 0, right = 0, good = 0, false_ones = 0, worse = 0, silent = 0;
  std::vector<double> shares;
  for (const InventedScore& s : scores) {
    if (s.clean) {
      ++clean, false_ones += !s.said.empty();
      continue;
    }
    ++laws, right += s.drivers_right, good += s.r2 >= 0.95, worse += s.r2 < -0.01, silent += s.said.empty();
    shares.push_back(s.r2);
  }
  std::sort(shares.begin(), shares.end());
  const auto percent = [](std::size_t k, std::size_t n) {
    return fmt::format("{:4} of {:4}  {:5.1f} %", k, n,
                       n == 0 ? 0.0 : 100.0 * static_cast<double>(k) / static_cast<double>(n));
  };
  return fmt::format(
      "laws whose drivers are right                  {}\n"
      "laws right on fresh motion (R^2 >= 0.95)      {}\n"
      "law removed on fresh motion, median           {:.3f}\n"
      "made worse on fresh motion                    {}\n"
      "nothing said of a law                         {}\n"
      "discoveries on clean recordings               {}\n",
      percent(right, laws), percent(good, laws), shares.empty() ? 0.0 : shares[shares.size() / 2], percent(worse, laws),
      percent(silent, laws), percent(false_ones, clean));
}

}  // namespace stillpoint::diag
