/// Faults that show in the raw values themselves, before any statistics: values repeated exactly, values on a lattice,
/// readings piled up at a rail, exact zeros. What is found here explains itself and mutes the samples it spoiled.
/// Effects M9, T5, T7, A10/G9/M12 and T8 of docs/effects.md.
#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "diagnosis/result.h"
#include "io/recording.h"
#include "simulation/config.h"

namespace stillpoint::diag {

/// Index of a triad in arrays over the sensors.
enum Sensor : int { kAcc = 0, kGyr = 1, kMag = 2 };
inline constexpr std::array<const char*, 3> kSensorName{"acc", "gyr", "mag"};
inline constexpr std::array<const char*, 3> kSensorWord{"accelerometer", "gyroscope", "magnetometer"};  ///< keys, too
inline constexpr std::array<const char*, 3> kSensorUnit{"m/s^2", "rad/s", "uT"};

/// What was found in one triad, for those who work with its samples afterwards.
struct SensorForensics {
  std::vector<std::uint8_t> muted;   ///< one per row: 1 where the reading is not a measurement; empty: none
  Vec3 lattice_step = Vec3::Zero();  ///< coarsest step per axis on which the values lie, unit of the reading; 0: none
  double hold_period = 1.0;          ///< rows per fresh value
  bool saturated = false, held = false, quantised = false;
};

struct Forensics {
  std::vector<Finding> findings;  ///< most samples spoiled first; effects that the simulation already has are left out
  std::vector<sim::EffectConfig> effects;  ///< the same as entries for the simulation
  std::array<SensorForensics, 3> sensor;
  std::vector<std::string> notices;

  [[nodiscard]] bool muted(Sensor s, std::size_t row) const {
    const auto& m = sensor[static_cast<std::size_t>(s)].muted;
    return !m.empty() && m[row] != 0;
  }
};

/// The triad's column of a recording; empty when it has none.
[[nodiscard]] const std::vector<Vec3>& triad(const io::Recording& recording, Sensor sensor);
/// The triad of a simulation; null when the simulation leaves it out.
[[nodiscard]] const sim::TriadConfig* triad(const sim::SimulationConfig& simulation, Sensor sensor);

/// Looks at every triad that both the recording and the simulation have. Cost: a few sorts of each column.
[[nodiscard]] Forensics examine_raw_values(const io::Recording& recording, const sim::SimulationConfig& simulation);

}  // namespace stillpoint::diag
