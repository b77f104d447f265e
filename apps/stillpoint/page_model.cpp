#include "apps/stillpoint/page_model.h"

#include <cmath>

#include "apps/stillpoint/live_words.h"

namespace stillpoint::app {
namespace {

constexpr double kFresh_s = 1.0;  // older than this an attitude is no longer drawn as the present one

/// The world's up in body coordinates: the third row of R(q_world_body).
Vec3 up_in_body(const std::array<double, 4>& xyzw) {
  const auto [x, y, z, w] = xyzw;
  return {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)};
}

}  // namespace

std::size_t part_of_sphere(const Vec3& direction) noexcept {
  Eigen::Index axis = 0;
  direction.cwiseAbs().maxCoeff(&axis);
  const auto face = static_cast<std::size_t>(2 * axis) + (direction[axis] < 0 ? 1U : 0U);
  const bool first = direction[(axis + 1) % 3] > 0;
  const bool second = direction[(axis + 2) % 3] > 0;
  return 4 * face + (second ? 2U : 0U) + (first ? 1U : 0U);
}

void PageModel::take(const WatchState& state, double t_s) {
  const std::lock_guard lock(mutex_);
  const double step_s = t_s - last_s_;
  last_s_ = t_s;
  CurvePoint point{.t_s = t_s};
  const bool is_fresh = state.attitude && state.age_s < kFresh_s && state.attitude->status != AttitudeStatus::kStale;
  if (is_fresh && state.attitude->status != AttitudeStatus::kInitializing) {
    const AttitudeMessage& m = *state.attitude;
    point.rpy_rad = array(roll_pitch_yaw(m.q_world_body_xyzw));
    point.sigma_rad = m.sigma_rpy_rad;
    point.at_rest = m.at_rest;
    if (m.at_rest && state.received != last_received_) rest(up_in_body(m.q_world_body_xyzw), t_s, step_s);
    last_received_ = state.received;
  }
  if (!point.at_rest && !rests_.empty()) rests_.back().going_on = false;
  curve_.push_back(point);
  while (t_s - curve_.front().t_s > kCurve_s) curve_.pop_front();
}

void PageModel::rest(const Vec3& up_body, double t_s, double step_s) {
  if (!(up_body.squaredNorm() > 0.5)) return;  // from the wire any numbers may come, also none
  if (rests_.empty() || !rests_.back().going_on) {
    rests_.push_back({.start_s = t_s});
    if (rests_.size() > kRests) rests_.pop_front();
  }
  rests_.back().seconds = t_s - rests_.back().start_s;
  rests_.back().up_body = array(up_body);
  rested_s_[part_of_sphere(up_body)] += step_s;
}

std::deque<CurvePoint> PageModel::curve() const {
  const std::lock_guard lock(mutex_);
  return curve_;
}

std::deque<SeenRest> PageModel::rests() const {
  const std::lock_guard lock(mutex_);
  return rests_;
}

std::array<double, kDirections> PageModel::rested_s() const {
  const std::lock_guard lock(mutex_);
  return rested_s_;
}

}  // namespace stillpoint::app
