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
      clock_(config.effects, config.rate_hz, seed),
      reference_(config, seed),
      tracker_(active_effects(config.effects, "sys_tracker")),
      frame_(active_effects(config.effects, "ref_frame")),
      lost_random_(seed, "timing lost"),
      aux_random_(seed, "environment noise"),
      now_t_s_(std::numeric_limits<double>::quiet_NaN()) {
  remembered_.fill({std::numeric_limits<double>::quiet_NaN(), {}});
  for (const auto& e : active_effects(config.effects, "sys_dup")) dup_.emplace_back(e, seed);
  SP_EXPECTS(frame_.size() <= 32);  // bits of a mask; the reader of the YAML refuses more
  for (const auto& f : frame_) R_sensor_body_.push_back(exp_so3(-f.values.vec3(0)));
  const std::optional<TriadConfig>* triads[] = {&config_.accelerometer, &config_.gyroscope, &config_.magnetometer};
  for (const Sensor sensor : kSensors)
    if (const auto& triad = *triads[static_cast<std::size_t>(sensor)]) add_chain(sensor, *triad, seed);
  // A duration is a sum of decimal steps: a millionth of a row makes no row.
  const double asked_s = config_.motion ? config_.motion->duration_s : motion_->duration_s();
  rows_ = static_cast<std::uint64_t>(std::min(motion_->duration_s(), asked_s) * config_.rate_hz + 1e-6);
}

void Simulator::add_chain(Sensor sensor, const TriadConfig& triad, std::uint64_t seed) {
  auto& chain = chains_[static_cast<std::size_t>(sensor)].emplace(Chain{{sensor, config_, triad, seed}, {}});
  const auto alike = [&](int a, int b) {
    return clock_.together(sensor, a, b) && std::all_of(frame_.begin(), frame_.end(), [&](const auto& f) {
             return f.covers(sensor, a) == f.covers(sensor, b);
           });
  };
  for (int axis = 0; axis < 3; ++axis) {
    auto& channels = chain.channels;
    const auto same =
        std::find_if(channels.begin(), channels.end(), [&](const auto& c) { return alike(c.axis, axis); });
    if (same != channels.end())
      same->axes[axis] = 1.0;
    else
      channels.push_back(
          {Element(sensor, config_, triad), axis, Vec3::Unit(axis), std::numeric_limits<double>::quiet_NaN()});
  }
  filters_ = filters_ || chain.channels.front().element.filters();
}

std::uint32_t Simulator::frames_of(Sensor sensor, int axis, double t_s) const noexcept {
  std::uint32_t frames = 0;
  for (std::size_t k = 0; k < frame_.size(); ++k)
    if (frame_[k].covers(sensor, axis) && frame_[k].active(t_s)) frames |= 1U << k;
  return frames;
}

MotionState Simulator::motion_at(double t_s) noexcept {
  if (!filters_) return motion_->at(t_s);
  for (const Remembered& r : remembered_)
    if (r.t_s == t_s) return r.motion;
  Remembered& r = remembered_[oldest_];
  oldest_ = (oldest_ + 1) % remembered_.size();
  r = {t_s, motion_->at(t_s)};
  return r.motion;
}

/// What a law of the file is driven by. At the row's own time it is the force, rate and field at the place.
Vec3 Simulator::driver_at(std::string_view name, double t_s) noexcept {
  if (name == "t") return Vec3::Constant(t_s);
  if (name == "T") return Vec3::Constant(environment_.temp_degC(t_s));
  if (name == "I") return Vec3::Constant(environment_.current_A(t_s));
  if (name == "V") return Vec3::Constant(environment_.supply_V(t_s));
  const bool now = t_s == now_t_s_;
  if (now && name == "w") return now_.rate_radps;
  if (now && name == "f") return now_.force_mps2;
  if (now && name == "m") return now_.field_uT;
  const bool kinematic =
      name == "w" || name == "f" || name == "m" || name == "p" || name == "east" || name == "north" || name == "up";
  if (!kinematic) return Vec3::Constant(environment_.user(name, t_s));
  const MotionState motion = now ? now_.motion : motion_at(t_s);
  if (name == "p") return motion.position_m;
  if (name == "w") return motion.rate_radps;
  const Mat3 R_body_world = now ? now_.R_body_world : motion.q_world_body.conjugate().toRotationMatrix();
  if (name == "f") return R_body_world * (motion.acceleration_mps2 + Vec3(0.0, 0.0, config_.gravity_mps2));
  if (name == "m") return R_body_world * config_.field_world_uT;
  return R_body_world.col(name == "east" ? 0 : name == "north" ? 1 : 2);
}

/// Everything true at one time, with force, rate and field bare.
void Simulator::fill_instant(double t_s, std::uint32_t frames) noexcept {
  now_.t_s = now_t_s_ = t_s;
  now_frames_ = frames;
  now_.motion = motion_at(t_s);
  now_.R_body_world = now_.motion.q_world_body.conjugate().toRotationMatrix();
  now_.temp_degC = environment_.temp_degC(t_s);
  now_.current_A = environment_.current_A(t_s);
  now_.supply_V = environment_.supply_V(t_s);
  now_.earth_rate_radps = environment_.earth_rate_radps();
  for (std::size_t k = 0; k < frame_.size(); ++k) {
    if ((frames >> k & 1U) == 0) continue;
    now_.R_body_world = R_sensor_body_[k] * now_.R_body_world;
    now_.motion.rate_radps = R_sensor_body_[k] * now_.motion.rate_radps;
    now_.motion.angular_acceleration_radps2 = R_sensor_body_[k] * now_.motion.angular_acceleration_radps2;
  }
  now_.force_mps2 = now_.R_body_world * (now_.motion.acceleration_mps2 + Vec3(0.0, 0.0, config_.gravity_mps2));
  now_.rate_radps = now_.motion.rate_radps;
  Vec3 field_world = config_.field_world_uT;
  if (environment_.has_iron()) field_world += environment_.iron_field_uT(now_.motion.position_m, t_s);
  now_.field_uT = now_.R_body_world * field_world;
  placed_.fill(false);
}

/// Force, rate or field with the laws of its place, at this time; other sensors' laws may read it afterwards.
const Vec3& Simulator::at_place(Sensor sensor, double t_s, std::uint32_t frames) noexcept {
  if (t_s != now_t_s_ || frames != now_frames_) fill_instant(t_s, frames);
  const auto i = static_cast<std::size_t>(sensor);
  Vec3& value = sensor == Sensor::kAcc ? now_.force_mps2 : sensor == Sensor::kGyr ? now_.rate_radps : now_.field_uT;
  if (chains_[i] && !placed_[i]) value = chains_[i]->channels.front().element.at_place(value, now_);
  placed_[i] = true;
  return value;
}

/// What the channel's element gives in this row.
Vec3 Simulator::signal_of(Sensor sensor, Channel& channel) noexcept {
  const double t = clock_.time_s(sensor, channel.axis);
  const double step_s = std::isnan(channel.last_t_s) ? 0.0 : std::max(0.0, t - channel.last_t_s);
  // The gyroscope's laws read the force at the accelerometer.
  const auto bring_to = [&](double time_s) -> const Vec3& {
    const std::uint32_t frames = frames_of(sensor, channel.axis, time_s);
    if (sensor == Sensor::kGyr) at_place(Sensor::kAcc, time_s, frames);
    return at_place(sensor, time_s, frames);
  };
  Vec3 signal;
  if (channel.element.filters() && step_s > 0.0) {
    const int steps = std::clamp(static_cast<int>(std::ceil(step_s / kFinestStep_s)), 1, kMostSteps);
    for (int k = 1; k <= steps; ++k) {
      const Vec3& truth = bring_to(k == steps ? t : channel.last_t_s + step_s * k / steps);
      signal = channel.element.signal(truth, now_, step_s / steps);
    }
  } else {
    const Vec3& truth = bring_to(t);
    signal = channel.element.signal(truth, now_, step_s);
  }
  channel.last_t_s = t;
  const Vec3 out = channel.element.output(
      signal, now_, step_s, [this](std::string_view name, double time_s) { return driver_at(name, time_s); });
  outside_table_ = outside_table_ || channel.element.outside_table();
  return out;
}

void Simulator::read_triad(Sensor sensor, double row_t_s, RawSample& out) noexcept {
  const auto i = static_cast<std::size_t>(sensor);
  Chain& chain = *chains_[i];
  Vec3 signal = signal_of(sensor, chain.channels.front());
  for (std::size_t k = 1; k < chain.channels.size(); ++k) {
    const Vec3 other = signal_of(sensor, chain.channels[k]);
    signal = (chain.channels[k].axes.array() != 0.0).select(other, signal);
  }
  const Vec3 y = chain.triad.reading(signal, row_t_s);
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
  if (!chains_[1]) return;
  const Triad& gyroscope = chains_[1]->triad;
  const double dt_s = 1.0 / config_.rate_hz;
  for (const auto& tracker : tracker_) {
    const double limit = tracker.values.scalar(1), share = std::min(1.0, dt_s / kShort_s);
    const Vec3 rate = gyroscope.corrected(vec(out.gyr_radps));
    rate_mean_ += share * (rate - rate_mean_);
    rate_spread_ += share * ((rate - rate_mean_).norm() - rate_spread_);
    const bool rest = rate_spread_ < limit && (rate_mean_ - tracked_bias_).norm() < 2.0 * limit;
    if (rest && tracker.active(row_t_s))
      tracked_bias_ += (1.0 - std::exp(-dt_s / tracker.values.scalar(0))) * (rate_mean_ - tracked_bias_);
    if (tracker.active(row_t_s)) vec(out.gyr_radps) -= gyroscope.inverse() * tracker.axes.cwiseProduct(tracked_bias_);
  }
}

void Simulator::transport(double row_t_s, RawSample& out) noexcept {
  for (auto& d : dup_) {
    const bool repeat = d.random.uniform() < d.values.scalar(0);
    if (!repeat || !d.active(row_t_s) || row_ == 0) continue;
    for (const Sensor sensor : kSensors) {
      const SamplePart part = kParts[static_cast<std::size_t>(sensor)];
      if (!d.covers(sensor)) continue;
      const bool whole = d.axes == Vec3::Ones(), before = last_sent_.holds(part);
      if (whole) out.has = static_cast<std::uint8_t>(before ? out.has | part : out.has & ~part);
      for (std::size_t axis = 0; axis < 3; ++axis)
        if (whole || (before && d.axes[static_cast<Eigen::Index>(axis)] != 0.0))
          slot(sensor, out)[axis] = slot(sensor, last_sent_)[axis];
    }
  }
  last_sent_ = out;
}

void Simulator::write_reference(double row_t_s, SimulatedSample& out) noexcept {
  const bool known = row_t_s == now_t_s_ && frame_.empty();
  const MotionState truth = known ? now_.motion : motion_at(row_t_s);
  const Mat3 R_body_world = truth.q_world_body.conjugate().toRotationMatrix();
  out.true_q_world_body = truth.q_world_body;
  out.true_position_m = truth.position_m;
  out.true_rate_radps = truth.rate_radps;
  out.moving = truth.moving;
  out.true_acc_mps2 = array(Vec3(R_body_world * (truth.acceleration_mps2 + Vec3(0.0, 0.0, config_.gravity_mps2))));
  out.true_gyr_radps = array(truth.rate_radps);
  out.true_mag_uT = array(Vec3(R_body_world * config_.field_world_uT));
  out.has_reference = config_.reference.kind != "none";
  const double latency_s = config_.reference.latency_s;
  const MotionState seen = latency_s == 0.0 ? truth : motion_at(row_t_s - latency_s);
  out.ref_q_world_body = seen.q_world_body;
  out.ref_position_m = seen.position_m;
  reference_.disturb(row_t_s, out.ref_q_world_body, out.ref_position_m);
}

bool Simulator::next(SimulatedSample& out) noexcept {
  for (; row_ < rows_; ++row_) {
    const double t = static_cast<double>(row_) / config_.rate_hz;
    out = {};
    out.sample.t_ns = std::llround(1e9 * t);
    out.sample.sequence = row_;
    const double temp_degC = environment_.temp_degC(t);
    clock_.start_row(t, temp_degC);
    for (const Sensor sensor : kSensors)
      if (has(sensor)) read_triad(sensor, t, out.sample);
    track_bias(t, out.sample);
    transport(t, out.sample);
    write_reference(t, out);
    out.sample.temp_degC = temp_degC + config_.environment.temperature.noise_K * aux_random_.normal();
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
  return chains_[static_cast<std::size_t>(sensor)]->triad.corrected(vec(y));
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
