/// The formats behind parameters.h, and what they share.
#pragma once
#include <array>

#include "exchange/parameters.h"

namespace stillpoint::exchange::parameters {

[[nodiscard]] Result<ReadParameters> read_sdf(const std::string& text, const std::string& name);
[[nodiscard]] WrittenParameters write_sdf(const sim::SimulationConfig& simulation);
[[nodiscard]] Result<ReadParameters> read_matlab(const std::string& text, const std::string& name);
[[nodiscard]] WrittenParameters write_matlab(const sim::SimulationConfig& simulation);
[[nodiscard]] Result<ReadParameters> read_kalibr(const std::string& text, const std::string& name);
[[nodiscard]] WrittenParameters write_kalibr(const sim::SimulationConfig& simulation);
[[nodiscard]] Result<ReadParameters> read_px4(const std::string& text, const std::string& name);
[[nodiscard]] WrittenParameters write_px4(const sim::SimulationConfig& simulation);
[[nodiscard]] Result<ReadParameters> read_sensor(const std::string& text, const std::string& name);
[[nodiscard]] WrittenParameters write_sensor(const sim::SimulationConfig& simulation);
[[nodiscard]] Result<ReadParameters> read_imu_calib(const std::string& text, const std::string& name);
[[nodiscard]] WrittenParameters write_imu_calib(const sim::SimulationConfig& simulation);

/// A sensor of a simulation with the words of lists and messages.
struct Part {
  const char* name;  ///< "accelerometer"
  sim::Sensor sensor;
  const std::optional<sim::TriadConfig>* triad;
};
[[nodiscard]] std::array<Part, 3> parts_of(const sim::SimulationConfig& simulation);

/// The matrix of readings: y = M v + B where ours says u = H (y - B).
[[nodiscard]] inline Mat3 of_readings(const sim::TriadConfig& t) { return t.matrix.inverse(); }

/// Effects that are not among `held`, one entry each.
void lose_effects(const sim::SimulationConfig& simulation, const std::vector<std::string>& held,
                  std::vector<std::string>& lost);

/// The first entry of this effect; nullptr where there is none.
[[nodiscard]] const sim::EffectConfig* entry_of(const sim::SimulationConfig& simulation, const std::string& id);
/// Its parameter as three numbers; zero where it has none.
[[nodiscard]] Vec3 three(const sim::EffectConfig* entry, const std::string& key);
void add_effect(sim::SimulationConfig& simulation, const std::string& id, const std::string& key, const Vec3& values);

}  // namespace stillpoint::exchange::parameters
