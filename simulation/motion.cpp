#include "simulation/motion.h"

#include "core/result.h"
#include "simulation/continuous_motion.h"
#include "simulation/segmented_motion.h"

namespace stillpoint::sim {

MotionState motion_state(const TaylorVec& p, const TaylorQuat& q, bool moving) noexcept {
  MotionState s;
  s.position_m = {p.at[0].x, p.at[1].x, p.at[2].x};
  s.velocity_mps = {p.at[0].d, p.at[1].d, p.at[2].d};
  s.acceleration_mps2 = {p.at[0].dd, p.at[1].dd, p.at[2].dd};
  s.q_world_body = Quat(q.w.x, q.x.x, q.y.x, q.z.x);
  // vec(q* r) for r = dq/dt and r = d2q/dt2
  const Vec3 v(q.x.x, q.y.x, q.z.x), first(q.x.d, q.y.d, q.z.d), second(q.x.dd, q.y.dd, q.z.dd);
  s.rate_radps = 2.0 * (q.w.x * first - q.w.d * v - v.cross(first));
  s.angular_acceleration_radps2 = 2.0 * (q.w.x * second - q.w.dd * v - v.cross(second));
  s.moving = moving;
  return s;
}

std::unique_ptr<Motion> make_motion(const MotionConfig& c, std::uint64_t seed) {
  if (c.kind == "rest_poses") return std::make_unique<SegmentedMotion>(rest_pose_segments(c, seed));
  if (c.kind == "hand") return std::make_unique<SegmentedMotion>(hand_segments(c, seed));
  if (c.kind == "worn_day") return std::make_unique<SegmentedMotion>(worn_day_segments(c, seed));
  if (c.kind == "turntable") return make_turntable(c, seed);
  if (c.kind == "tumble") return make_tumble(c, seed);
  if (c.kind == "walking") return make_walking(c, seed);
  if (c.kind == "vehicle") return make_vehicle(c, seed);
  if (c.kind == "boat") return make_boat(c, seed);
  SP_EXPECTS(c.kind == "drone");
  return make_drone(c, seed);
}

}  // namespace stillpoint::sim
