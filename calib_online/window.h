/// A rest window: what the sensor thread hands to the calibration thread. Everything the calibration learns, it learns
/// from these. After Gietzelt et al., "Performance comparison of accelerometer calibration algorithms based on
/// 3D-ellipsoid fitting methods", section 2.4 (inactivity sections), and Zhang, "Two-Step Calibration Methods for
/// Miniature Inertial and Magnetic Sensor Units", eq. (24) (rotations between orientations); docs/math/rest.md.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <type_traits>

#include "core/types.h"

namespace stillpoint::calib {

using Array27 = std::array<double, 27>;  ///< a 3x9 matrix, row-major

/// The order of the triads wherever they stand in an array, and their bits.
inline constexpr std::size_t kAccIndex = 0, kGyrIndex = 1, kMagIndex = 2;
inline constexpr std::array<std::uint8_t, 3> kTriadBits{kAcc, kGyr, kMag};

/// Why a stretch of samples is not a rest window.
enum class Refusal : std::uint8_t {
  kNone,
  kFilling,             ///< not enough samples yet
  kNoAccelerometer,     ///< no specific force in the samples
  kGap,                 ///< samples are missing inside the window
  kStuck,               ///< the readings do not change at all
  kClipped,             ///< a reading sits at the sensor's limit
  kVibrating,           ///< an engine or the like: the mean is rectified vibration
  kSwaying,             ///< the rate changes inside the window: a boat, a hand
  kTurning,             ///< gravity, the field or the known gyro bias say that the body turns steadily
  kLinearAcceleration,  ///< the specific force changes in a way that no rotation explains
  kNotGravity,          ///< the calibrated norm is too far from gravity for the calibration's own uncertainty
  kUnknownRate,         ///< steady, and beyond what is known of the gyro's bias: a turn, or another bias
};
[[nodiscard]] std::string_view name(Refusal refusal) noexcept;

/// Means are those of the raw readings, turned to the middle of the window by the gyroscope.
struct Window {
  std::int64_t t_start_ns = 0;
  std::int64_t t_end_ns = 0;
  std::uint32_t samples = 0;
  std::uint8_t has = 0;  ///< bits of SamplePart: the means below that were measured
  /// kNone: rest. kSwaying, kTurning: the specific force holds, the rate does not. kNotGravity, kUnknownRate: steady,
  /// but against what is known; attitudes will show which of the two is wrong.
  Refusal refusal = Refusal::kNone;
  std::uint8_t stuck = 0, clipped = 0;  ///< bits of SamplePart: triads that do not change, or sit at their limit. A
                                        ///< window that holds nothing else (has = 0) tells that this has changed
  bool rotation_valid = false;          ///< the gyroscope saw the whole way from the previous window
  bool moved = true;                    ///< the body was really moved since the previous window, not only refused
  Array3 acc_mps2{}, gyr_radps{}, mag_uT{};
  Array9 acc_cov{}, gyr_cov{}, mag_cov{};  ///< of the means, from inside the window, squares of those units
  Array9 turn_cov{};  ///< (rad/s)^2, body: steady turning that gravity and the field cannot exclude. It is one unknown
                      ///< for a whole stretch of rest and does not average out.
  Array3 gyr_rounding_var{};  ///< (rad/s)^2, of the gyroscope's mean, raw axes: what its lattice hides where noise does
                              ///< not carry it across the steps. The same in every rest, as the bias is.
  double temp_degC = 25.0;
  Array4 q_previous_this{1, 0, 0, 0};                 ///< v_previous = R(q) v_this, middle of the window to middle
  Array9 rotation_cov{};                              ///< rad^2, of the rotation vector in this window's body frame
  Array27 d_rotation_d_matrix{};                      ///< rotation vector (this frame) by the rows of the gyro's H
  Array9 d_rotation_d_bias{};                         ///< the same by the gyro's bias, s
  Array9 gyr_matrix_used{1, 0, 0, 0, 1, 0, 0, 0, 1};  ///< H at which the rotation was integrated
  Array3 gyr_bias_used{};                             ///< at which it was integrated
  double rotation_path_rad = 0.0;                     ///< length of the way, not of its result
  double rotation_s = 0.0;                            ///< time from middle to middle
};
static_assert(std::is_trivially_copyable_v<Window>, "windows cross a ring between the two threads");

}  // namespace stillpoint::calib
