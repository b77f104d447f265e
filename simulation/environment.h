/// Surroundings of the sensor as pure functions of time: temperature, current, supply voltage, moving iron.
#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "simulation/config.h"
#include "simulation/motion.h"

namespace stillpoint::sim {

/// Values over time: straight lines between the points, or steps. Before the first and after the last the end values.
struct TimeSeries {
  std::vector<double> t_s, value;
  bool steps = false;

  [[nodiscard]] double at(double time_s) const noexcept;
};

/// Measured temperature, current and supply that take the place of the configured ones; an empty series does not.
struct RecordedEnvironment {
  TimeSeries temp_degC, current_A, supply_V;
  std::map<std::string, TimeSeries, std::less<>> user;  ///< further columns, for laws that name them
};

class Environment {
 public:
  /// Draws what is random in the surroundings and looks at the motion where they follow it.
  Environment(const EnvironmentConfig& config, const Motion& motion, RecordedEnvironment recorded, std::uint64_t seed);

  [[nodiscard]] double temp_degC(double t_s) const noexcept;
  [[nodiscard]] double current_A(double t_s) const noexcept;
  [[nodiscard]] double supply_V(double t_s) const noexcept;
  /// A user column; 0 where it was not recorded.
  [[nodiscard]] double user(std::string_view name, double t_s) const noexcept;
  /// Field of the moving iron at a point of the world, uT.
  [[nodiscard]] Vec3 iron_field_uT(const Vec3& position_m, double t_s) const noexcept;
  /// Earth rotation in ENU, rad/s.
  [[nodiscard]] Vec3 earth_rate_radps() const noexcept { return earth_rate_radps_; }
  [[nodiscard]] bool has_iron() const noexcept { return !config_.iron.empty(); }

 private:
  enum class Course { kConstant, kWarmUp, kChamber, kDay, kActivity };

  EnvironmentConfig config_;
  Course course_;
  RecordedEnvironment recorded_;
  TimeSeries heating_;  ///< 0 to 1, for temperature that follows activity
  TimeSeries load_A_;
  Vec3 earth_rate_radps_;
};

}  // namespace stillpoint::sim
