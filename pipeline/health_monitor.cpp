#include "pipeline/health_monitor.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/so3.h"
#include "core/units.h"

namespace stillpoint::pipeline {
namespace {

constexpr double kStuckTurn_rad = 1.0;  ///< a magnetometer may be slow; the body turning beneath it is not
constexpr double kStuckAxis_s = 1.5;
/// Of the other two axes, while one repeats itself.
constexpr double kAccMoved_mps2 = 4.0, kGyrMoved_radps = 1.0, kMagMoved_uT = 10.0;
constexpr double kClippedShare = 0.02;
/// Mean norm of specific force: of a hand or a runner 8 to 13 m/s^2, shaken hard 25; in g it is 1, in mg 1000.
constexpr double kSmallestForce_mps2 = 5.0, kLargestForce_mps2 = 60.0;
constexpr double kNoForce_mps2 = 2.0;        ///< for a second: a fall of 5 m, or g
constexpr double kWrongForce = 0.2;          ///< of g, at rest, after calibration
constexpr double kLargestRate_radps = 30.0;  ///< not 1700 deg/s for ten seconds; degrees read as radians do
constexpr double kRest_s = 1.0;
constexpr double kAbsurdRate_radps = 50.0;  ///< nor 2900 for one
constexpr double kSpikes = 1.5;             ///< in ten seconds: one may happen
constexpr double kWindow_s = 0.6, kEnds_s = 0.1;
constexpr double kQuiet = 0.15;  ///< of g: at both ends the body accelerates little
/// Of g^2: by the gyroscope gravity has moved by 0.5 rad, beyond what the acceleration of such ends pretends.
constexpr double kSmallestTurn2 = 0.3;
/// On a pendulum, an arm that swings or a turntable, the force stands still in the body while the body turns: that is
/// no contradiction. A mirrored axis leaves the force a change of a quarter of what it pretends, or more.
constexpr double kPendulum = 0.2;
/// Of g. Violent motion changes the force as a wrong turn does, but accelerations average out over seconds in axes that
/// do not turn; axes that a wrong gyroscope carries along turn, and gravity does not add up in them.
constexpr double kAddsUp = 0.9;
constexpr double kTurnsMemory_s = 30.0, kVerdictMemory_s = 60.0;
constexpr double kFast_s = 1.0, kSlow_s = 3.0;
/// In axes that do not turn a mean of 1.35 g over a second needs 3.4 m/s gained upward, and then another second's.
constexpr double kStrong = 1.35, kStrong_s = 1.0;
constexpr double kApart = 0.64, kApart_s = 0.3;  ///< cosine: 50 deg, beyond any acceleration of a second
constexpr double kWeak = 0.15;                   ///< of g: less has no direction
constexpr double kContradiction_s = 20.0;
constexpr int kWindows = 5;
constexpr double kForget = 0.9;
constexpr std::int64_t kUnled_ns = 1'000'000'000;
/// A thermometer speaks seldom, and some only when the temperature has changed.
constexpr double kTempSilent_s = 10.0;
constexpr double kFaultyShare = 0.5;  ///< of the change that the gyroscope leaves unexplained

SensorHealth healthy() { return {}; }
/// `evidence` over its limit is above 1.
SensorHealth faulty(Fault fault, double evidence) { return {Health::kFaulty, fault, 0, evidence}; }
SensorHealth suspect(Fault fault, double evidence) { return {Health::kSuspect, fault, 0, evidence}; }

SensorHealth graver(const SensorHealth& a, const SensorHealth& b) { return a.state < b.state ? b : a; }

/// One more state: the time with which it began is kept while it lasts.
void follow(SensorHealth& now, SensorHealth found, std::int64_t t_ns) {
  found.since_ns = found.state == now.state && found.fault == now.fault ? now.since_ns : t_ns;
  now = found;
}

}  // namespace

void HealthMonitor::hear(std::span<const Finding> findings) noexcept {
  found_ = {};
  for (const Finding& f : findings) {
    if (!f.stands) continue;
    switch (f.oddity) {
      case Oddity::kAccScale:
        found_.acc = faulty(Fault::kUnits, 1.0);
        break;
      case Oddity::kGyrScale:
      case Oddity::kGyrSilent:
      case Oddity::kTimeScale:  // a turn is rate times time
        found_.gyr = faulty(Fault::kUnits, 1.0);
        break;
      case Oddity::kMagScale:
        found_.mag = faulty(Fault::kUnits, 1.0);
        break;
      case Oddity::kTempScale:
        found_.temp = faulty(Fault::kUnits, 1.0);
        break;
      case Oddity::kTooSlow:
        found_.gyr = graver(found_.gyr, suspect(Fault::kLate, 1.0));
        break;
      case Oddity::kRepeated:
        found_.acc = graver(found_.acc, suspect(Fault::kRepeated, 1.0));
        found_.gyr = graver(found_.gyr, suspect(Fault::kRepeated, 1.0));
        break;
      case Oddity::kTempDead:
        found_.temp = graver(found_.temp, suspect(Fault::kStuck, 1.0));
        break;
      case Oddity::kTimeStopped:  // the guard's concern: it was so once
      case Oddity::kTimeBackward:
      case Oddity::kTimeJumped:
        break;
    }
  }
}

void HealthMonitor::follow_gravity(const CalibratedSample& sample, double dt_s) noexcept {
  Turns& t = turns_;
  if (!sample.holds(kGyr) || dt_s > kEnds_s) {
    t.begun = false;
    t.mean_s = t.since_s = 0.0;
    return;
  }
  t.q = array(quat(t.q) * exp_quat(dt_s * vec(sample.gyr_radps)));
  const Quat turned = quat(t.q);
  t.since_s += dt_s;
  if (t.since_s > kWindow_s - kEnds_s && sample.holds(kAcc)) {
    // In the frame of the window's start, so that turning within the mean does not blur it.
    t.mean_s += dt_s;
    vec(t.mean) += dt_s / t.mean_s * (turned * vec(sample.acc_mps2) - Vec3(vec(t.mean)));
  }
  if (t.since_s < kWindow_s) return;
  const Vec3 end_in_start = vec(t.mean), start = vec(t.before);
  const Vec3 end = turned.conjugate() * end_in_start;
  const auto quiet = [](const Vec3& f) {
    return std::abs(f.norm() - kStandardGravity_mps2) < kQuiet * kStandardGravity_mps2;
  };
  const double g2 = kStandardGravity_mps2 * kStandardGravity_mps2;
  const double predicted = (turned.conjugate() * start - start).squaredNorm();
  const double with = (end_in_start - start).squaredNorm(), without = (end - start).squaredNorm();
  t.unseen_s += t.since_s;
  if (t.unseen_s > (t.windows < kWindows ? kTurnsMemory_s : kVerdictMemory_s)) t.windows = 0;
  const bool turned_enough = t.begun && t.mean_s > 0.0 && predicted > kSmallestTurn2 * g2;
  if (turned_enough && quiet(start) && quiet(end) && without > kPendulum * with) {
    t.with = kForget * t.with + with;
    t.without = kForget * t.without + without;
    t.pull = kForget * t.pull + vec(pull_.slow).norm() / kStandardGravity_mps2;
    t.weight = kForget * t.weight + 1.0;
    t.windows = std::min(t.windows + 1, kWindows);
    t.unseen_s = 0.0;
  }
  t.before = array(end);
  t.begun = t.mean_s > 0.0;
  t.q = {1, 0, 0, 0};
  t.mean = {};
  t.mean_s = t.since_s = 0.0;
}

/// What is constant in the world averages to gravity however the body turns. A wrong scale makes it too large; a sensor
/// that mirrors, exchanges or loses an axis makes it jump to another direction, which the turn does not explain.
void HealthMonitor::follow_pull(const CalibratedSample& sample, const Array3& rate_radps, double dt_s) noexcept {
  Pull& p = pull_;
  p.contradicted_s = std::max(0.0, p.contradicted_s - dt_s);
  if (!sample.holds(kGyr) || dt_s > kEnds_s) {
    p = {.contradicted_s = p.contradicted_s};
    return;
  }
  const Mat3 carry = exp_so3(Vec3(-dt_s * vec(rate_radps)));
  for (Array3* mean : {&p.fast, &p.slow}) vec(*mean) = carry * vec(*mean);
  if (!sample.holds(kAcc) || dt_s <= 0.0) return;
  p.over_s += dt_s;
  const Vec3 force = vec(sample.acc_mps2);
  vec(p.fast) += dt_s / std::min(p.over_s, kFast_s) * (force - Vec3(vec(p.fast)));
  vec(p.slow) += dt_s / std::min(p.over_s, kSlow_s) * (force - Vec3(vec(p.slow)));
  if (p.over_s < kSlow_s) return;
  const Vec3 fast = vec(p.fast) / kStandardGravity_mps2, slow = vec(p.slow) / kStandardGravity_mps2;
  p.strong_s = fast.norm() > kStrong ? p.strong_s + dt_s : 0.0;
  const bool apart = std::min(fast.norm(), slow.norm()) > kWeak && fast.dot(slow) < kApart * fast.norm() * slow.norm();
  p.apart_s = apart ? p.apart_s + dt_s : 0.0;
  if (p.apart_s > kApart_s) p.contradicted_s = kContradiction_s;
}

SensorHealth HealthMonitor::judge_acc(const GuardedSample& g, bool offset_jumped) const noexcept {
  if ((g.absent & kAcc) != 0 || !acc_.heard) return {Health::kAbsent, Fault::kAbsent};
  if (acc_.zero_s > kStuck_s) return faulty(Fault::kZero, acc_.zero_s / kStuck_s);
  if (acc_.same_s > kStuck_s && gyr_.same_s < kStuck_s) return faulty(Fault::kStuck, acc_.same_s / kStuck_s);
  if (bus_hangs()) return faulty(Fault::kStuck, acc_.same_s / kStuck_s);
  if (const double s = acc_.stuck_axis_s(kAccMoved_mps2); s > kStuckAxis_s)
    return faulty(Fault::kStuck, s / kStuckAxis_s);
  if (acc_.norm_now.over_s >= kNow_s && acc_.norm_now.value < kNoForce_mps2)
    return faulty(Fault::kUnits, kNoForce_mps2 / std::max(acc_.norm_now.value, 1e-9));
  if (acc_.norm.over_s >= kMean_s && (acc_.norm.value < kSmallestForce_mps2 || acc_.norm.value > kLargestForce_mps2))
    return faulty(Fault::kUnits, std::max(kSmallestForce_mps2 / std::max(acc_.norm.value, 1e-9),
                                          acc_.norm.value / kLargestForce_mps2));
  const double odd = std::abs(rest_norm_ / kStandardGravity_mps2 - 1.0);
  if (rest_s_ >= kRest_s && odd > kWrongForce) return faulty(Fault::kScale, odd / kWrongForce);
  if (pull_.strong_s > kStrong_s) return faulty(Fault::kScale, pull_.strong_s / kStrong_s);
  if (const double over = acc_noise_.excess(); over > 1.0) return suspect(Fault::kNoisy, over);
  if (acc_.spikes > kSpikes) return suspect(Fault::kSpikes, acc_.spikes / kSpikes);
  if (acc_.clipped > kClippedShare) return suspect(Fault::kClipped, acc_.clipped / kClippedShare);
  if (offset_jumped) return suspect(Fault::kOffset, 1.0);
  return healthy();
}

SensorHealth HealthMonitor::judge_gyr(const GuardedSample& g, bool offset_jumped) const noexcept {
  if ((g.absent & kGyr) != 0 || !gyr_.heard) return {Health::kAbsent, Fault::kAbsent};
  const bool acc_lives = acc_.heard && acc_.same_s < kStuck_s;
  if (acc_lives && gyr_.zero_s > kStuck_s) return faulty(Fault::kZero, gyr_.zero_s / kStuck_s);
  if (acc_lives && gyr_.same_s > kStuck_s) return faulty(Fault::kStuck, gyr_.same_s / kStuck_s);
  if (bus_hangs()) return faulty(Fault::kStuck, gyr_.same_s / kStuck_s);
  if (const double s = gyr_.stuck_axis_s(kGyrMoved_radps); s > kStuckAxis_s)
    return faulty(Fault::kStuck, s / kStuckAxis_s);
  if ((gyr_.norm.over_s >= kMean_s && gyr_.norm.value > kLargestRate_radps) ||
      (gyr_.norm_now.over_s >= kNow_s && gyr_.norm_now.value > kAbsurdRate_radps))
    return faulty(Fault::kUnits, std::max(gyr_.norm.value, gyr_.norm_now.value) / kLargestRate_radps);
  if (turns_.windows >= kWindows && turns_.pull < kAddsUp * turns_.weight) {
    // Gravity in the body changes by the turn alone. What the gyroscope leaves of that change is its contradiction.
    const double left = turns_.with / std::max(turns_.with, turns_.without);
    if (left > kFaultyShare) return faulty(Fault::kAxes, left / kFaultyShare);
  }
  if (pull_.contradicted_s > 0.0) return faulty(Fault::kInconsistent, 1.0 + pull_.contradicted_s / kContradiction_s);
  if (const double over = gyr_noise_.excess(); over > 1.0) return suspect(Fault::kNoisy, over);
  if (gyr_.spikes > kSpikes) return suspect(Fault::kSpikes, gyr_.spikes / kSpikes);
  if (gyr_.clipped > kClippedShare) return suspect(Fault::kClipped, gyr_.clipped / kClippedShare);
  if (offset_jumped) return suspect(Fault::kOffset, 1.0);
  return healthy();
}

SensorHealth HealthMonitor::judge_mag(const GuardedSample& g, HeadingReference heading) const noexcept {
  if ((g.absent & kMag) != 0 || !mag_.heard) return {Health::kAbsent, Fault::kAbsent};
  if (mag_.zero_s > kStuck_s) return faulty(Fault::kZero, mag_.zero_s / kStuck_s);
  if (mag_.same_s > kStuck_s && mag_same_turn_rad_ > kStuckTurn_rad)
    return faulty(Fault::kStuck, mag_same_turn_rad_ / kStuckTurn_rad);
  if (const double s = mag_.stuck_axis_s(kMagMoved_uT); s > kStuckAxis_s)
    return faulty(Fault::kStuck, s / kStuckAxis_s);
  if (mag_.spikes > kSpikes) return suspect(Fault::kSpikes, mag_.spikes / kSpikes);
  if (heading == HeadingReference::kDisturbed) return suspect(Fault::kDisturbed, 1.0);
  return healthy();
}

SensorHealth HealthMonitor::judge_temp(const GuardedSample& g) const noexcept {
  const bool silent = (g.absent & kTemp) != 0 && temp_silent_s_ > kTempSilent_s;
  if (!temp_heard_ || silent) return {Health::kAbsent, Fault::kAbsent};
  return found_.temp;
}

void HealthMonitor::wait(const RawSample& row, std::uint8_t absent) noexcept {
  if (!waiting_since_ns_ || row.t_ns < *waiting_since_ns_) waiting_since_ns_ = row.t_ns;
  for (const auto& [part, health] : {std::pair{kMag, &health_.mag}, std::pair{kTemp, &health_.temp}})
    if (row.holds(part) && health->state == Health::kAbsent) follow(*health, healthy(), row.t_ns);
  if (row.t_ns - *waiting_since_ns_ < kUnled_ns) return;
  for (const auto& [part, health] : {std::pair{kAcc, &health_.acc}, std::pair{kGyr, &health_.gyr}})
    if ((absent & part) != 0) follow(*health, {Health::kAbsent, Fault::kAbsent}, *waiting_since_ns_);
}

SensorsHealth HealthMonitor::observe(const GuardedSample& guarded, const CalibratedSample& corrected,
                                     const fusion::AttitudeEstimate& estimate) noexcept {
  const RawSample& s = guarded.sample;
  const double dt_s = started_ ? in_seconds(s.t_ns - last_ns_) : 0.0;
  last_ns_ = s.t_ns;
  if (!started_) health_ = {};  // so that an absence begins here
  started_ = true;
  waiting_since_ns_.reset();
  if (s.holds(kAcc)) acc_.note(s.acc_mps2, (guarded.clipped & kAcc) != 0, dt_s);
  if (s.holds(kGyr)) gyr_.note(s.gyr_radps, (guarded.clipped & kGyr) != 0, dt_s);
  if (s.holds(kMag)) mag_.note(s.mag_uT, (guarded.clipped & kMag) != 0, dt_s);
  if (guarded.after_gap)
    for (NoiseWatch* watch : {&acc_noise_, &gyr_noise_}) watch->interrupt();
  if (s.holds(kAcc)) acc_noise_.note(s.acc_mps2, dt_s, !estimate.at_rest);
  if (s.holds(kGyr)) gyr_noise_.note(s.gyr_radps, dt_s, !estimate.at_rest);
  for (const auto& [part, readings] : {std::pair{kAcc, &acc_}, std::pair{kGyr, &gyr_}, std::pair{kMag, &mag_}})
    readings->spikes += ((guarded.spikes & part) != 0 ? 1.0 : 0.0) - std::min(1.0, dt_s / kMean_s) * readings->spikes;
  rest_s_ = estimate.at_rest ? std::min(rest_s_ + dt_s, kRest_s) : 0.0;
  if (rest_s_ > 0.0 && corrected.holds(kAcc))
    rest_norm_ += dt_s / rest_s_ * (vec(corrected.acc_mps2).norm() - rest_norm_);
  mag_same_turn_rad_ = mag_.same_s > 0.0 ? mag_same_turn_rad_ + dt_s * vec(estimate.rate_body_radps).norm() : 0.0;
  temp_heard_ |= s.holds(kTemp);
  temp_silent_s_ = s.holds(kTemp) ? 0.0 : temp_silent_s_ + dt_s;
  follow_gravity(corrected, dt_s);
  follow_pull(corrected, estimate.rate_body_radps, dt_s);
  if (estimate.denied) pull_.contradicted_s = kContradiction_s;
  follow(health_.acc, graver(judge_acc(guarded, estimate.acc_offset_jumped), found_.acc), s.t_ns);
  follow(health_.gyr, graver(judge_gyr(guarded, estimate.gyro_offset_jumped), found_.gyr), s.t_ns);
  follow(health_.mag, graver(judge_mag(guarded, estimate.heading), found_.mag), s.t_ns);
  follow(health_.temp, judge_temp(guarded), s.t_ns);
  return health_;
}

bool HealthMonitor::unfounded(const SensorsHealth& health) noexcept {
  const auto wrong = [](const SensorHealth& h) {
    return h.state == Health::kFaulty && (h.fault == Fault::kAxes || h.fault == Fault::kUnits ||
                                          h.fault == Fault::kScale || h.fault == Fault::kInconsistent);
  };
  const auto stuck = [](const SensorHealth& h) { return h.state == Health::kFaulty && h.fault == Fault::kStuck; };
  return wrong(health.acc) || wrong(health.gyr) || (stuck(health.acc) && stuck(health.gyr));
}

}  // namespace stillpoint::pipeline
