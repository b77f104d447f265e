/// What the calibration thread hands to the sensor thread: for each sensor the parameters of u = H (y - B(T)),
/// what is known about their error, and why there are none where there are none.
/// After Zhang, "Two-Step Calibration Methods for Miniature Inertial and Magnetic Sensor Units", eqs. (5), (18)-(22).
#pragma once
#include <algorithm>
#include <cstdint>
#include <string_view>
#include <type_traits>

#include "core/types.h"

namespace stillpoint {

enum class CalibrationStatus : std::uint8_t {
  kFactory,              ///< the values of the configuration or the identity: nothing learnt yet
  kOk,                   ///< learnt, and better than the prior
  kTooFewWindows,        ///< not enough rest windows
  kNotObservable,        ///< the directions seen lie in one plane or around one axis
  kNotPositiveDefinite,  ///< the fit is not an ellipsoid
  kClipped,              ///< the readings sit at the sensor's limit
  kStuck,                ///< the readings do not change at all
  kReplaced,             ///< the evidence contradicts what was learnt: another sensor
};

[[nodiscard]] constexpr std::string_view name(CalibrationStatus status) noexcept {
  constexpr std::string_view kNames[] = {
      "factory", "ok", "too_few_windows", "not_observable", "not_positive_definite", "clipped", "stuck", "replaced"};
  return kNames[static_cast<std::size_t>(status)];
}

/// Parameters of one triad, in the sensor's own units. B(T) = b0 + b1 tau + b2 tau^2 with tau = T - T_ref,
/// T held inside the range of temperatures that were seen: never extrapolated.
struct TriadCalibration {
  Array9 matrix{1, 0, 0, 0, 1, 0, 0, 0, 1};  ///< H, row-major
  Array3 bias{};                             ///< b0, same unit as the reading
  Array3 bias_per_K{};                       ///< b1
  Array3 bias_per_K2{};                      ///< b2
  double temp_ref_degC = 25.0;
  double temp_min_degC = 25.0;  ///< coldest and warmest temperature with evidence
  double temp_max_degC = 25.0;
  Array9 bias_covariance{};   ///< of b0, unit^2; zeros where unknown
  Array9 matrix_sd{};         ///< of each element of H; zeros where unknown
  double norm_sd = 0.0;       ///< sd of the calibrated norm, rms over the sphere, in units of the reading; 0 unknown
  std::uint32_t windows = 0;  ///< rest windows behind these numbers
  CalibrationStatus status = CalibrationStatus::kFactory;

  [[nodiscard]] Vec3 bias_at(double temp_degC) const noexcept {
    const double tau = std::clamp(temp_degC, temp_min_degC, temp_max_degC) - temp_ref_degC;
    return vec(bias) + tau * (vec(bias_per_K) + tau * vec(bias_per_K2));
  }
  /// u = H (y - B(T))
  [[nodiscard]] Vec3 apply(const Array3& reading, double temp_degC) const noexcept {
    return mat(matrix) * (vec(reading) - bias_at(temp_degC));
  }
};

struct CalibrationSnapshot {
  std::uint64_t version = 0;  ///< 0 is the factory calibration; every change counts one up
  std::int64_t t_ns = 0;      ///< time of the sample that completed the evidence
  TriadCalibration acc, gyr, mag;
};

static_assert(std::is_trivially_copyable_v<CalibrationSnapshot>);

}  // namespace stillpoint
