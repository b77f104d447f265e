/// The memoryless laws of the catalogue: what one effect adds to a true vector, given everything true at that instant.
/// Each is one line of laws.cpp, written from the catalogue's equation.
#pragma once
#include <vector>

#include "simulation/active_effect.h"
#include "simulation/environment.h"
#include "simulation/motion.h"

namespace stillpoint::sim {

/// Everything true at one instant. `force`, `rate` and `field` are at the sensor, in its frame.
struct Instant {
  double t_s = 0.0;
  MotionState motion;
  Mat3 R_body_world = Mat3::Identity();
  double temp_degC = 0.0, current_A = 0.0, supply_V = 0.0;
  Vec3 earth_rate_radps = Vec3::Zero();  ///< in the world
  Vec3 force_mps2 = Vec3::Zero(), rate_radps = Vec3::Zero(), field_uT = Vec3::Zero();
};

/// Where in the sensor a law acts. The laws of the place see the bare kinematics; those of the element see the force,
/// rate and field that arrive at the element.
enum class Stage { kPlace, kElement };

using Law = Vec3 (*)(const EffectValues& p, const Instant& now);

struct ActiveLaw : ActiveEffect {
  Law law;
  ActiveLaw(const EffectConfig& effect, Law its_law) : ActiveEffect(effect), law(its_law) {}
};

/// Laws among the effects that belong to this sensor and stage.
[[nodiscard]] std::vector<ActiveLaw> laws_for(const std::vector<EffectConfig>& effects, Sensor sensor, Stage stage);

/// Sum of what the laws add at this instant.
[[nodiscard]] Vec3 sum_of(const std::vector<ActiveLaw>& laws, const Instant& now) noexcept;

}  // namespace stillpoint::sim
