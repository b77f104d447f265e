/// Factors by which a customary unit differs from the one that the column's name claims.
#pragma once
#include <span>

#include "core/units.h"
#include "diagnosis/sanity/sanity.h"

namespace stillpoint::diag::detail {

struct UnitMistake {
  double factor;      ///< readings are this many times too large
  const char* words;  ///< what they look like, and what to do
};

inline constexpr UnitMistake kForceUnits[] = {
    {1.0 / kStandardGravity_mps2, "g instead of m/s^2"},
    {1e3 / kStandardGravity_mps2, "milli-g instead of m/s^2"},
    {kStandardGravity_mps2, "m/s^2 multiplied by g once too often"},
    {3.28084, "feet/s^2 instead of m/s^2"},
};
inline constexpr UnitMistake kFieldUnits[] = {
    {10.0, "milligauss instead of uT"}, {0.01, "gauss instead of uT"}, {1e3, "nT instead of uT"},
    {1e-3, "mT instead of uT"},         {1e-6, "tesla instead of uT"},
};
inline constexpr UnitMistake kRateUnits[] = {
    {kDegPerRad, "degrees per second; name the columns gyr_x_dps ... or convert them"},
    {1e3 * kDegPerRad, "milli-degrees per second; divide by 1000 and name the columns gyr_x_dps ..."},
    {1e3, "milliradians per second, or raw counts at 2000 deg/s (16.4 a deg/s); convert them"},
    {9.549297, "revolutions per minute; multiply by 0.10472"},
    {1.0 / kDegPerRad, "radians per second divided by 57.3 once too often, or named gyr_x_dps by mistake"},
};
inline constexpr UnitMistake kLengthUnits[] = {
    {1e3, "millimetres; divide by 1000"},    {100.0, "centimetres; divide by 100"},
    {39.3701, "inches; multiply by 0.0254"}, {3.28084, "feet; multiply by 0.3048"},
    {1e-3, "kilometres; multiply by 1000"},
};

/// The unit whose factor `ratio` is, within a factor of `within`; null when there is none.
[[nodiscard]] constexpr const UnitMistake* unit_of(double ratio, std::span<const UnitMistake> units, double within) {
  for (const UnitMistake& u : units)
    if (ratio < within * u.factor && ratio * within > u.factor) return &u;
  return nullptr;
}

/// The gyroscope reads `slope` times the turns that `witness` shows: a clock, a unit or counts, when it is far from 1.
void check_rate_scale(double slope, const char* witness, const io::Recording& recording,
                      const sim::SimulationConfig& simulation, Sanity& out);

}  // namespace stillpoint::diag::detail
