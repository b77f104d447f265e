#include "simulation/simulator.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/result.h"
#include "core/so3.h"

namespace stillpoint::sim {
namespace {

/// A filter sees its input at least this often, whatever the rate of the recording.
constexpr double kFinestStep_s = 0.0025;
constexpr int kMostSteps = 16;

std::vector<ActiveEffect> all_of(const SimulationConfig& c, const char* id) {
  std::vector<ActiveEffect> out;
  for (const auto& e : c.effects)
    if (e.id == id) out.emplace_back(e);
  return out;
}

constexpr SamplePart kParts[] = {kAcc, kGyr, kMag};

Array3& slot(Sensor sensor, RawSample& sample) {
  return sensor == Sensor::kAcc ? sample.acc_mps2 : sensor == Sensor::kGyr ? sample.gyr_radps : sample.mag_uT;
}

}  // namespace

Simulator::Simulator(const SimulationConfig& config, std::shared_ptr<const Motion> motion, std::uint64_t seed,
                     RecordedEnvironment recorded)
    : config_(config),
      motion_(std::move(motion)),
      environment_(config.environment, *motion_, std::move(recorded), seed),
      offset_(all_of(config, "sys_offset")),
      skew_(all_of(config, "sys_skew")),
      gap_(all_of(config, "sys_gap")),
      dup_(all_of(config, "sys_dup")),
      jitter_(all_of(config, "sys_jitter")),
      tracker_(all_of(config, "sys_tracker")),
      frame_(all_of(config, "ref_frame")),
      jitter_random_(seed, "sys_jitter"),
      dup_random_(seed, "sys_dup"),
      lost_random_(seed, "timing lost"),
      aux_random_(seed, "environment noise"),
      now_t_s_(std::numeric_limits<double>::quiet_NaN()) {
  const std::optional<TriadConfig>* triads[] = {&config_.accelerometer, &config_.gyroscope, &config_.magnetometer};
  for (std::size_t i = 0; i < 3; ++i)
    if (*triads[i]) triads_[i].emplace(static_cast<Sensor>(i), config_, **triads[i], seed);
  last_t_s_.fill(std::numeric_limits<double>::quiet_NaN());
  for (const auto& f : frame_) R_sensor_body_ = exp_so3(-f.values.vec3(0)) * R_sensor_body_;
  const double step_s = 1.0 / config_.rate_hz;
  const auto errors = [&](double orientation_sd, double position_sd, double band_hz) {
    orientation_error_.emplace(orientation_sd, band_hz, step_s, seed, "reference orientation");
    position_error_.emplace(position_sd, band_hz, step_s, seed, "reference position");
  };
  if (const auto& r = config_.reference; r.kind == "mocap") errors(r.orientation_sd_rad, r.position_sd_m, r.band_hz);
  for (const auto& e : all_of(config, "ref_error")) errors(e.values.scalar(0), e.values.scalar(1), e.values.scalar(2));
  // A duration is a sum of decimal steps: a millionth of a row makes no row.
  const double asked_s = config_.motion ? config_.motion->duration_s : motion_->duration_s();
  rows_ = static_cast<std::uint64_t>(std::min(motion_->duration_s(), asked_s) * config_.rate_hz + 1e-6);
}

/// Everything true at one time, with force, rate and field bare.
void Simulator::fill_instant(double t_s) noexcept {
  now_.t_s = t_s;
  now_.motion = motion_->at(t_s);
  now_.R_body_world = now_.motion.q_world_body.conjugate().toRotationMatrix();
  now_.temp_degC = environment_.temp_degC(t_s);
  now_.current_A = environment_.current_A(t_s);
  now_.supply_V = environment_.supply_V(t_s);
  now_.earth_rate_radps = environment_.earth_rate_radps();
  if (!frame_.empty()) {
    now_.R_body_world = R_sensor_body_ * now_.R_body_world;
    now_.motion.rate_radps = R_sensor_body_ * now_.motion.rate_radps;
    now_.motion.angular_acceleration_radps2 = R_sensor_body_ * now_.motion.angular_acceleration_radps2;
  }
  now_.force_mps2 = now_.R_body_world * (now_.motion.acceleration_mps2 + Vec3(0.0, 0.0, config_.gravity_mps2));
  now_.rate_radps = now_.motion.rate_radps;
  Vec3 field_world = config_.field_world_uT;
  if (environment_.has_iron()) field_world += environment_.iron_field_uT(now_.motion.position_m, t_s);
  now_.field_uT = now_.R_body_world * field_world;
  placed_.fill(false);
}

/// Force, rate or field with the laws of its place, at this time; other sensors' laws may read it afterwards.
const Vec3& Simulator::at_place(Sensor sensor, double t_s) noexcept {
  if (t_s != now_t_s_) fill_instant(now_t_s_ = t_s);
  const auto i = static_cast<std::size_t>(sensor);
  Vec3& value = sensor == Sensor::kAcc ? now_.force_mps2 : sensor == Sensor::kGyr ? now_.rate_radps : now_.field_uT;
  if (triads_[i] && !placed_[i]) value = triads_[i]->at_place(value, now_);
  placed_[i] = true;
  return value;
}

double Simulator::imu_time_s(double row_t_s) noexcept {
  double t = row_t_s;
  for (const auto& s : skew_)
    if (s.active(row_t_s)) t += 1e-6 * s.values.scalar(0) * row_t_s;
  for (const auto& g : gap_)
    if (g.active(row_t_s) && row_t_s > g.values.scalar(1)) t += g.values.scalar(0) / config_.rate_hz;
  for (const auto& o : offset_)
    if (o.active(row_t_s)) t -= o.values.scalar(0);
  for (const auto& j : jitter_)
    if (const double shift = j.values.scalar(0) * jitter_random_.normal(); j.active(row_t_s)) t += shift;
  return t;
}

void Simulator::read_triad(Sensor sensor, double row_t_s, double imu_t_s, RawSample& out) noexcept {
  const auto i = static_cast<std::size_t>(sensor);
  Triad& triad = *triads_[i];
  const double t = imu_t_s - triad.delay_s(row_t_s);
  const double step_s = std::isnan(last_t_s_[i]) ? 0.0 : std::max(0.0, t - last_t_s_[i]);
  // The gyroscope's laws read the force at the accelerometer.
  const auto bring_to = [&](double time_s) -> const Vec3& {
    if (sensor == Sensor::kGyr) at_place(Sensor::kAcc, time_s);
    return at_place(sensor, time_s);
  };
  Vec3 signal;
  if (triad.filters() && step_s > 0.0) {
    const int steps = std::clamp(static_cast<int>(std::ceil(step_s / kFinestStep_s)), 1, kMostSteps);
    for (int k = 1; k <= steps; ++k) {
      const Vec3& truth = bring_to(k == steps ? t : last_t_s_[i] + step_s * k / steps);
      signal = triad.element(truth, now_, step_s / steps);
    }
  } else {
    const Vec3& truth = bring_to(t);
    signal = triad.element(truth, now_, step_s);
  }
  last_t_s_[i] = t;
  const Vec3 y = triad.reading(signal, now_, step_s);
  if (!due(sensor)) return;
  slot(sensor, out) = array(y);
  out.has = static_cast<std::uint8_t>(out.has | kParts[i]);
}

bool Simulator::due(Sensor sensor) const noexcept {
  const auto& c = sensor == Sensor::kAcc   ? config_.accelerometer
                  : sensor == Sensor::kGyr ? config_.gyroscope
                                           : config_.magnetometer;
  if (c->rate_hz <= 0.0 || c->rate_hz >= config_.rate_hz || row_ == 0) return true;
  const double ratio = c->rate_hz / config_.rate_hz, k = static_cast<double>(row_);
  return std::floor(k * ratio) != std::floor((k - 1.0) * ratio);
}

/// A sensor hub that takes the mean rate at rest for bias. It knows only its own readings: rest is where the rate stays
/// near its short mean and near the bias it believes in.
void Simulator::track_bias(double row_t_s, RawSample& out) noexcept {
  constexpr double kShort_s = 0.5;
  if (!triads_[1]) return;
  const double dt_s = 1.0 / config_.rate_hz;
  for (const auto& tracker : tracker_) {
    const double limit = tracker.values.scalar(1), share = std::min(1.0, dt_s / kShort_s);
    const Vec3 rate = triads_[1]->corrected(vec(out.gyr_radps));
    rate_mean_ += share * (rate - rate_mean_);
    rate_spread_ += share * ((rate - rate_mean_).norm() - rate_spread_);
    const bool rest = rate_spread_ < limit && (rate_mean_ - tracked_bias_).norm() < 2.0 * limit;
    if (rest && tracker.active(row_t_s))
      tracked_bias_ += (1.0 - std::exp(-dt_s / tracker.values.scalar(0))) * (rate_mean_ - tracked_bias_);
    if (tracker.active(row_t_s)) vec(out.gyr_radps) -= triads_[1]->inverse() * tracker.axes.cwiseProduct(tracked_bias_);
  }
}

void Simulator::transport(double row_t_s, RawSample& out) noexcept {
  for (const auto& d : dup_) {
    const bool repeat = dup_random_.uniform() < d.values.scalar(0);
    if (!repeat || !d.active(row_t_s) || row_ == 0) continue;
    out.acc_mps2 = last_sent_.acc_mps2;
    out.gyr_radps = last_sent_.gyr_radps;
    out.mag_uT = last_sent_.mag_uT;
    out.has = last_sent_.has;
  }
  last_sent_ = out;
}

void Simulator::write_reference(double row_t_s, SimulatedSample& out) noexcept {
  const bool known = row_t_s == now_t_s_ && frame_.empty();
  const MotionState truth = known ? now_.motion : motion_->at(row_t_s);
  const Mat3 R_body_world = truth.q_world_body.conjugate().toRotationMatrix();
  out.true_q_world_body = truth.q_world_body;
  out.true_position_m = truth.position_m;
  out.true_rate_radps = truth.rate_radps;
  out.moving = truth.moving;
  out.true_acc_mps2 = array(Vec3(R_body_world * (truth.acceleration_mps2 + Vec3(0.0, 0.0, config_.gravity_mps2))));
  out.true_gyr_radps = array(truth.rate_radps);
  out.true_mag_uT = array(Vec3(R_body_world * config_.field_world_uT));
  out.has_reference = config_.reference.kind != "none";
  out.ref_q_world_body = truth.q_world_body;
  out.ref_position_m = truth.position_m;
  if (!orientation_error_) return;
  out.ref_q_world_body = (truth.q_world_body * stillpoint::exp_quat(orientation_error_->next())).normalized();
  out.ref_position_m += position_error_->next();
}

bool Simulator::next(SimulatedSample& out) noexcept {
  for (; row_ < rows_; ++row_) {
    const double t = static_cast<double>(row_) / config_.rate_hz;
    out = {};
    out.sample.t_ns = std::llround(1e9 * t);
    out.sample.sequence = row_;
    const double imu_t = imu_time_s(t);
    for (std::size_t i = 0; i < 3; ++i)
      if (triads_[i]) read_triad(static_cast<Sensor>(i), t, imu_t, out.sample);
    track_bias(t, out.sample);
    transport(t, out.sample);
    write_reference(t, out);
    out.sample.temp_degC = environment_.temp_degC(t) + config_.environment.temperature.noise_K * aux_random_.normal();
    out.sample.has = static_cast<std::uint8_t>(out.sample.has | kTemp);
    out.current_A = environment_.current_A(t) + config_.environment.current.noise_A * aux_random_.normal();
    out.supply_V = environment_.supply_V(t) + config_.environment.supply.noise_V * aux_random_.normal();
    const bool lost = config_.timing.lost_fraction > 0.0 && lost_random_.uniform() < config_.timing.lost_fraction;
    if (lost) continue;
    ++row_;
    return true;
  }
  return false;
}

Vec3 Simulator::corrected(Sensor sensor, const Array3& y) const noexcept {
  return triads_[static_cast<std::size_t>(sensor)]->corrected(vec(y));
}

std::vector<SimulatedSample> simulate(const SimulationConfig& config, std::shared_ptr<const Motion> motion,
                                      std::uint64_t seed, RecordedEnvironment recorded) {
  std::vector<SimulatedSample> rows;
  Simulator simulator(config, std::move(motion), seed, std::move(recorded));
  for (SimulatedSample row; simulator.next(row);) rows.push_back(row);
  return rows;
}

std::vector<SimulatedSample> simulate(const SimulationConfig& config, std::uint64_t seed) {
  SP_EXPECTS(config.motion.has_value());
  return simulate(config, make_motion(*config.motion, seed), seed);
}

}  // namespace stillpoint::sim
