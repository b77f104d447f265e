/// An effect of the configuration made ready for the simulator: its numbers, where it acts and when.
#pragma once
#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "simulation/config.h"

namespace stillpoint::sim {

/// Numbers of one effect in the catalogue's order of parameters, defaults filled in.
class EffectValues {
 public:
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

struct ActiveEffect {
  EffectValues values;
  Vec3 axes = Vec3::Ones();       ///< 1 on chosen axes, else 0
  std::array<bool, 3> sensors{};  ///< acc, gyr, mag: what it acts on
  double from_s = 0.0, to_s = 0.0;
  std::string source;  ///< of its random numbers: each entry has a stream of its own

  /// `entry`: how many of its ID there are up to this one.
  explicit ActiveEffect(const EffectConfig& effect, int entry = 1);
  [[nodiscard]] bool active(double t_s) const noexcept { return t_s >= from_s && t_s <= to_s; }
  [[nodiscard]] bool on(int axis, double t_s) const noexcept { return axes[axis] != 0.0 && active(t_s); }
  [[nodiscard]] bool covers(Sensor sensor) const noexcept { return sensors[static_cast<std::size_t>(sensor)]; }
  [[nodiscard]] bool covers(Sensor sensor, int axis) const noexcept { return covers(sensor) && axes[axis] != 0.0; }
  /// `changed` on the effect's axes while it is active, else `plain`; no arithmetic, so that repeats stay exact.
  [[nodiscard]] Vec3 choose(const Vec3& changed, const Vec3& plain, double t_s) const noexcept {
    Vec3 out = plain;
    for (int i = 0; i < 3; ++i)
      if (on(i, t_s)) out[i] = changed[i];
    return out;
  }
};

/// Those with this ID, in the order of the configuration.
[[nodiscard]] std::vector<ActiveEffect> active_effects(const std::vector<EffectConfig>& effects, std::string_view id);

}  // namespace stillpoint::sim
