#include "simulation/segmented_motion.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/directions.h"
#include "core/result.h"
#include "core/so3.h"
#include "core/units.h"
#include "simulation/random.h"

namespace stillpoint::sim {
namespace {

Quat end_pose(const Segment& s) { return (s.from_q_world_body * stillpoint::exp_quat(s.turn_rad)).normalized(); }

/// Builds the chain: each segment starts where the last one ended.
class Chain {
 public:
  explicit Chain(const Quat& start) : pose_(start) {}

  [[nodiscard]] double time_s() const { return time_s_; }

  void rest(double length_s) {
    if (length_s <= 0.0) return;
    Segment s;
    s.start_s = time_s_;
    s.end_s = time_s_ += length_s;
    s.from_q_world_body = pose_;
    s.from_m = place_;
    all_.push_back(s);
  }

  /// A bout that ends in the given pose and place; returns it so that swings can be put in.
  Segment& bout(double length_s, const Quat& to, const Vec3& place_m) {
    Segment s;
    s.start_s = time_s_;
    s.end_s = time_s_ += length_s;
    s.moving = true;
    s.from_q_world_body = pose_;
    s.turn_rad = log_quat(pose_.conjugate() * to);
    s.from_m = place_;
    s.shift_m = place_m - place_;
    s.swell_s = std::min(0.7, 0.35 * length_s);
    pose_ = end_pose(s);
    place_ = place_m;
    all_.push_back(s);
    return all_.back();
  }

  std::vector<Segment> take() { return std::move(all_); }

 private:
  Quat pose_;
  Vec3 place_ = Vec3::Zero();
  double time_s_ = 0.0;
  std::vector<Segment> all_;
};

/// One draw a statement, here and below: in which order the arguments of a call are evaluated is the compiler's choice,
/// and one seed is one motion on every processor.
Quat random_attitude(Stream& random) {
  const double z = random.normal(), y = random.normal(), x = random.normal(), w = random.normal();
  return Quat(w, x, y, z).normalized();
}

/// Attitude whose up direction, seen from the body, is `up`, turned by `yaw` about it.
Quat attitude_with_up(const Vec3& up, double yaw_rad) {
  return (Quat(Eigen::AngleAxisd(yaw_rad, Vec3::UnitZ())) * turn_between(up, Vec3::UnitZ())).normalized();
}

/// A swing of the given rms per axis.
Swing swing(Stream& random, double frequency_hz, double rms) {
  const Vec3 c = random.normal3(), s = random.normal3();
  return {kTwoPi * frequency_hz, rms * c, rms * s};
}

/// Body rates of about `rate` rms per axis, displacements of about `sway` rms, over three frequencies of the hand.
void put_swings(Segment& s, Stream& random, double rate_radps, double sway_m) {
  constexpr std::array<std::array<double, 2>, 3> kBands_hz{{{0.3, 0.8}, {0.8, 1.8}, {1.8, 3.2}}};
  constexpr std::array<double, 3> kRotationShare{0.65, 0.6, 0.45}, kTranslationShare{0.85, 0.5, 0.15};
  for (std::size_t i = 0; i < 3; ++i) {
    const double turn_hz = random.uniform(kBands_hz[i][0], kBands_hz[i][1]);
    const double shift_hz = random.uniform(kBands_hz[i][0], kBands_hz[i][1]);
    s.rotation[i] = swing(random, turn_hz, kRotationShare[i] * rate_radps / (kTwoPi * turn_hz));
    s.translation[i] = swing(random, shift_hz, kTranslationShare[i] * sway_m);
  }
}

Taylor envelope(const Segment& s, const Taylor& t) {
  const Taylor rise = smooth_step((1.0 / s.swell_s) * (t - s.start_s));
  const Taylor fall = smooth_step((1.0 / s.swell_s) * (-t + s.end_s));
  return rise * fall;
}

void add_swings(TaylorVec& to, const std::array<Swing, 3>& swings, const Taylor& size, double t_s) {
  Vec3 value = Vec3::Zero(), first = Vec3::Zero(), second = Vec3::Zero();
  for (const Swing& w : swings) {
    if (w.frequency_radps == 0.0) continue;
    const double c = std::cos(w.frequency_radps * t_s), s = std::sin(w.frequency_radps * t_s), k = w.frequency_radps;
    const Vec3 here = c * w.cosine + s * w.sine;
    value += here;
    first += k * (c * w.sine - s * w.cosine);
    second -= k * k * here;
  }
  for (std::size_t i = 0; i < 3; ++i) {
    const auto axis = static_cast<Eigen::Index>(i);
    to.at[i] = to.at[i] + size * Taylor{value[axis], first[axis], second[axis]};
  }
}

TaylorVec fixed(const Vec3& v) { return {{Taylor{v.x(), 0, 0}, Taylor{v.y(), 0, 0}, Taylor{v.z(), 0, 0}}}; }

}  // namespace

SegmentedMotion::SegmentedMotion(std::vector<Segment> segments) : segments_(std::move(segments)) {
  SP_EXPECTS(!segments_.empty());
}

MotionState SegmentedMotion::at(double t_s) const noexcept {
  const auto after = std::upper_bound(segments_.begin(), segments_.end(), t_s,
                                      [](double t, const Segment& s) { return t < s.start_s; });
  const Segment& s = after == segments_.begin() ? segments_.front() : *(after - 1);
  if (!s.moving || t_s >= s.end_s || t_s < s.start_s) {
    MotionState still;
    const bool ended = s.moving && t_s >= s.end_s;
    still.q_world_body = ended ? end_pose(s) : s.from_q_world_body;
    still.position_m = ended ? Vec3(s.from_m + s.shift_m) : s.from_m;
    return still;
  }
  const Taylor t = Taylor::time(t_s);
  const Taylor step = smooth_step((1.0 / (s.end_s - s.start_s)) * (t - s.start_s));
  const Taylor size = envelope(s, t);
  TaylorVec position = fixed(s.from_m), turn, sway;
  position.add(s.shift_m, step);
  add_swings(position, s.translation, size, t_s);
  turn.add(s.turn_rad, step);
  add_swings(sway, s.rotation, size, t_s);
  return motion_state(position, constant(s.from_q_world_body) * (exp_quat(turn) * exp_quat(sway)), true);
}

std::vector<Segment> rest_pose_segments(const MotionConfig& c, std::uint64_t seed) {
  Stream random(seed, "motion rest_poses");
  std::vector<int> order(static_cast<std::size_t>(c.poses));
  for (int i = 0; i < c.poses; ++i) order[static_cast<std::size_t>(i)] = i;
  for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random.bits() % i]);
  const auto pose = [&](std::size_t k) {
    const double golden = std::numbers::pi * (3.0 - std::sqrt(5.0));
    const int i = order[k % order.size()];
    const double z = 1.0 - (2.0 * i + 1.0) / c.poses, r = std::sqrt(1.0 - z * z);
    return attitude_with_up({r * std::cos(golden * i), r * std::sin(golden * i), z}, random.uniform(0.0, kTwoPi));
  };
  Chain chain(pose(0));
  for (std::size_t k = 1; chain.time_s() < c.duration_s; ++k) {
    chain.rest(std::max(0.1, random.uniform(c.min_rest_s, c.max_rest_s)));
    chain.bout(c.move_s, pose(k), Vec3::Zero());
  }
  return chain.take();
}

std::vector<Segment> hand_segments(const MotionConfig& c, std::uint64_t seed) {
  Stream random(seed, "motion hand");
  Chain chain(random_attitude(random));
  while (chain.time_s() < c.duration_s) {
    chain.rest(random.uniform(c.min_rest_s, c.max_rest_s));
    const Vec3 place = 0.5 * c.sway_m * random.normal3();
    const double length_s = random.uniform(c.min_bout_s, c.max_bout_s);
    put_swings(chain.bout(length_s, random_attitude(random), place), random, c.rate_radps, c.sway_m);
  }
  return chain.take();
}

std::vector<Segment> worn_day_segments(const MotionConfig& c, std::uint64_t seed) {
  Stream random(seed, "motion worn_day");
  // An arm at rest: palm down on the desk, hanging, across the body, and the two attitudes of sleep.
  const std::array<Vec3, 5> kUp{Vec3(0.1, 0.1, 1.0), Vec3(-1.0, 0.1, 0.2), Vec3(0.2, -0.8, 0.6), Vec3(0.0, 0.9, 0.5),
                                Vec3(0.1, -0.2, -1.0)};
  const auto pose = [&](bool asleep) {
    const std::size_t which = asleep ? 2 + random.bits() % 3 : (random.uniform() < 0.7 ? 0 : 1 + random.bits() % 2);
    const double yaw_rad = random.uniform(0.0, kTwoPi);
    return attitude_with_up((kUp[which].normalized() + 0.08 * random.normal3()).normalized(), yaw_rad);
  };
  Chain chain(pose(true));
  while (chain.time_s() < c.duration_s) {
    const double hour = std::fmod(chain.time_s() / 3600.0, 24.0);
    const bool asleep = hour < 7.0 || hour >= 23.0;
    chain.rest(asleep ? random.uniform(300.0, 2400.0) : random.uniform(c.min_rest_s, 20.0 * c.max_rest_s));
    const bool walk = !asleep && random.uniform() < 0.1;
    const double length_s = walk ? random.uniform(60.0, 900.0) : random.uniform(1.0, c.max_bout_s);
    const Vec3 place_m = 0.2 * random.normal3();
    Segment& s = chain.bout(length_s, pose(asleep), place_m);
    if (!walk) {
      put_swings(s, random, (asleep ? 0.3 : 0.7) * c.rate_radps, c.sway_m);
      continue;
    }
    const double step_hz = random.uniform(1.6, 2.1);
    s.rotation = {swing(random, 0.5 * step_hz, 0.15), swing(random, step_hz, 0.05), swing(random, 2.0 * step_hz, 0.01)};
    s.translation = {swing(random, 0.5 * step_hz, 0.06), swing(random, step_hz, 0.02),
                     swing(random, 2.0 * step_hz, 0.004)};
  }
  return chain.take();
}

}  // namespace stillpoint::sim
