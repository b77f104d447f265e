/// Every effect a simulation can switch on and a diagnosis can name: the one source of IDs, equations, drivers and
/// parameters with their units. The YAML reader, the simulator, the diagnosis and docs/effects.md all read this table.
///
/// Symbols: u = H (y - B) corrected reading; f specific force, w body rate, m field, all true and in the sensor frame;
/// R body to world; T - T0 temperature against 25 degC; D the error added: u = true + D + noise; * elementwise.
#pragma once
#include <string>
#include <string_view>
#include <vector>

namespace stillpoint::sim {

inline constexpr double kReferenceTemp_degC = 25.0;
inline constexpr double kReferenceSupply_V = 3.7;

struct EffectParameter {
  std::string key;     ///< in YAML, with its unit: "k_radps_per_K"
  std::string symbol;  ///< in the equation: "k"
  std::string unit;    ///< for people and the diagnosis: "rad/s/K"
  int count = 1;       ///< 1, 3 (x, y, z) or 9 (row-major); where 3 are due one number serves all three
  double typical_low = 0.0, typical_high = 0.0;  ///< usual magnitude of one number
  bool required = true;
  double fallback = 0.0;  ///< each number, where the parameter is not required and not given
};

struct EffectInfo {
  std::string id;
  std::string entry;   ///< place in the catalogue: "A1"
  std::string sensor;  ///< acc, gyr, mag, sys (all sensors) or ref (the reference)
  std::string title;
  std::string equation;
  std::string driver;
  std::string excited_by;
  std::string mistaken_for;
  std::string told_apart_by;
  std::vector<EffectParameter> parameters;

  [[nodiscard]] const EffectParameter* parameter(std::string_view key) const;
  /// True where the effect acts on the axes of several sensors, so that `sensors` may choose among them.
  [[nodiscard]] bool takes_sensors() const;
};

/// In the order of the catalogue: acc_, gyr_, mag_, sys_, ref_.
[[nodiscard]] const std::vector<EffectInfo>& effect_catalogue();

/// nullptr where the ID is not known.
[[nodiscard]] const EffectInfo* find_effect(std::string_view id);

/// The catalogue as a page of Markdown: what `stillpoint effects` prints and docs/effects.md holds.
[[nodiscard]] std::string effect_catalogue_page();

}  // namespace stillpoint::sim
