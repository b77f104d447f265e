/// Motion of the body as a pure function of time: the same time gives the same state, in any order of asking.
#pragma once
#include <cstdint>
#include <memory>

#include "core/types.h"
#include "simulation/config.h"
#include "simulation/taylor.h"

namespace stillpoint::sim {

/// The body's reference point in the world (ENU). Rates in the body frame.
struct MotionState {
  Vec3 position_m = Vec3::Zero();
  Vec3 velocity_mps = Vec3::Zero();
  Vec3 acceleration_mps2 = Vec3::Zero();
  Quat q_world_body = Quat::Identity();
  Vec3 rate_radps = Vec3::Zero();
  Vec3 angular_acceleration_radps2 = Vec3::Zero();
  bool moving = false;
};

class Motion {
 public:
  virtual ~Motion() = default;
  /// Defined for every time; outside [0, duration] a motion goes on as it would. Allocates nothing.
  [[nodiscard]] virtual MotionState at(double t_s) const noexcept = 0;
  [[nodiscard]] virtual double duration_s() const noexcept = 0;
};

/// State from path and orientation with their derivatives: omega = 2 vec(q* dq/dt) and, because dq*/dt dq/dt is real
/// for a unit quaternion, d omega/dt = 2 vec(q* d2q/dt2). The quaternion need only be close to unit length (1e-12).
[[nodiscard]] MotionState motion_state(const TaylorVec& position, const TaylorQuat& q, bool moving) noexcept;

/// Pre: config.kind is one of motion_kind_names(). The seed draws the poses and bouts, never the sensors' noise.
[[nodiscard]] std::unique_ptr<Motion> make_motion(const MotionConfig& config, std::uint64_t seed);

}  // namespace stillpoint::sim
