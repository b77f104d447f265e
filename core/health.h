/// The health of each sensor, as the pipeline judges it from every kind of evidence: one state, one reason.
/// The numbers are those of the wire (idl/stillpoint.idl).
#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <string_view>
#include <type_traits>

namespace stillpoint {

enum class Health : std::uint8_t {
  kOk,
  kSuspect,  ///< evidence against it, not yet enough: used with more variance
  kFaulty,   ///< not believed
  kAbsent,   ///< no reading for longer than its own period allows, or none at all
};

/// Why a sensor is not healthy. One reason at a time: the gravest.
enum class Fault : std::uint8_t {
  kNone,
  kAbsent,        ///< no readings
  kStuck,         ///< readings repeat to the last bit
  kZero,          ///< readings are zero
  kClipped,       ///< readings sit at the full scale
  kSpikes,        ///< single readings that no motion can give
  kNoisy,         ///< far noisier than it was
  kOffset,        ///< its offset has jumped
  kScale,         ///< its scale contradicts the other sensors
  kAxes,          ///< axes swapped, mirrored or turned
  kLate,          ///< readings arrive or are stamped too late
  kRepeated,      ///< readings come twice
  kClock,         ///< its clock jumps, stands still or runs backwards
  kUnits,         ///< its readings cannot be in the stated unit
  kDisturbed,     ///< magnetometer: the field is not the reference field
  kInconsistent,  ///< contradicts the other sensors in a way that has no name above
};

[[nodiscard]] constexpr std::string_view name(Health health) noexcept {
  constexpr std::string_view kNames[] = {"ok", "suspect", "faulty", "absent"};
  const auto i = static_cast<std::size_t>(health);
  return i < std::size(kNames) ? kNames[i] : "unknown";
}
[[nodiscard]] constexpr std::string_view name(Fault fault) noexcept {
  constexpr std::string_view kNames[] = {"none",  "absent", "stuck",     "zero",        "clipped", "spikes",
                                         "noisy", "offset", "scale",     "axes",        "late",    "repeated",
                                         "clock", "units",  "disturbed", "inconsistent"};
  const auto i = static_cast<std::size_t>(fault);
  return i < std::size(kNames) ? kNames[i] : "unknown";
}

struct SensorHealth {
  Health state = Health::kOk;
  Fault fault = Fault::kNone;
  std::int64_t since_ns = 0;  ///< time of the sample with which this state began
  double evidence = 0.0;      ///< the statistic behind it over its limit: above 1 it is exceeded
};

/// Of every sensor of one device.
struct SensorsHealth {
  SensorHealth acc, gyr, mag, temp;

  /// The gravest state of the sensors that the attitude stands on. An absent magnetometer or thermometer is no fault.
  [[nodiscard]] Health worst() const noexcept {
    const Health field = mag.state == Health::kAbsent ? Health::kOk : mag.state;
    const Health heat = temp.state == Health::kFaulty ? Health::kFaulty : Health::kOk;
    return std::max({acc.state, gyr.state, field, heat});
  }
};

/// Before any reading came.
[[nodiscard]] constexpr SensorsHealth unheard() noexcept {
  constexpr SensorHealth kAbsent{Health::kAbsent, Fault::kAbsent};
  return {kAbsent, kAbsent, kAbsent, kAbsent};
}

static_assert(std::is_trivially_copyable_v<SensorsHealth>);

}  // namespace stillpoint
