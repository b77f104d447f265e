/// The memoryless laws of the catalogue: what one effect adds to a true vector, given everything true at that instant.
/// Each is one line of laws.cpp, written from the catalogue's equation.
#pragma once
#include <array>
#include <optional>
#include <string_view>
#include <vector>

#include "simulation/config.h"
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

/// Numbers of one effect in the catalogue's order of parameters, defaults filled in.
class EffectValues {
 public:
  EffectValues() = default;
  explicit EffectValues(const EffectConfig& config);  ///< Pre: the ID is in the catalogue, the counts are right

  [[nodiscard]] double scalar(std::size_t parameter) const noexcept { return numbers_[offset_[parameter]]; }
  [[nodiscard]] Vec3 vec3(std::size_t parameter) const noexcept { return Vec3(numbers_.data() + offset_[parameter]); }
  [[nodiscard]] Mat3 mat3(std::size_t parameter) const noexcept {
    return RowMajor3(numbers_.data() + offset_[parameter]);
  }

 private:
  std::array<double, 16> numbers_{};
  std::array<std::size_t, 4> offset_{};
};

enum class Sensor { kAcc, kGyr, kMag };

/// Where in the sensor a law acts. The laws of the place see the bare kinematics; those of the element see the force,
/// rate and field that arrive at the element.
enum class Stage { kPlace, kElement };

using Law = Vec3 (*)(const EffectValues& p, const Instant& now);

/// A law switched on, with its axes and its window.
struct ActiveLaw {
  Law law = nullptr;
  EffectValues values;
  Vec3 axes = Vec3::Ones();  ///< 1 on chosen axes, else 0
  double from_s = 0.0, to_s = 0.0;

  [[nodiscard]] bool active(double t_s) const noexcept { return t_s >= from_s && t_s <= to_s; }
};

[[nodiscard]] Vec3 axes_mask(const EffectConfig& effect);
[[nodiscard]] std::pair<double, double> window_of(const EffectConfig& effect);

/// Laws among the effects that belong to this sensor and stage.
[[nodiscard]] std::vector<ActiveLaw> laws_for(const std::vector<EffectConfig>& effects, Sensor sensor, Stage stage);

/// Sum of what the laws add at this instant.
[[nodiscard]] Vec3 sum_of(const std::vector<ActiveLaw>& laws, const Instant& now) noexcept;

}  // namespace stillpoint::sim
