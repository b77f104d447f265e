/// The samples that travel through every stage, and the short names for the Eigen types used with them.
/// Units are SI and radians; temperature is in degC and the magnetic field in uT, as in the files (docs/formats.md).
/// Body frame: x forward, y left, z up. World frame: ENU. At rest with z up an accelerometer reads +g (specific force).
#pragma once
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <type_traits>

namespace stillpoint {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;
using Quat = Eigen::Quaterniond;  ///< Hamilton; q_world_body rotates body vectors into the world

/// Plain storage for anything that crosses a ring, a snapshot cell or the wire:
/// Eigen 3.4 vectors are not trivially copyable.
using Array3 = std::array<double, 3>;
using Array4 = std::array<double, 4>;  ///< a quaternion w, x, y, z
using Array9 = std::array<double, 9>;  ///< a 3x3 matrix, row-major

using RowMajor3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
inline Eigen::Map<const Vec3> vec(const Array3& a) { return Eigen::Map<const Vec3>(a.data()); }
inline Eigen::Map<Vec3> vec(Array3& a) { return Eigen::Map<Vec3>(a.data()); }
inline Eigen::Map<const RowMajor3> mat(const Array9& a) { return Eigen::Map<const RowMajor3>(a.data()); }
inline Eigen::Map<RowMajor3> mat(Array9& a) { return Eigen::Map<RowMajor3>(a.data()); }
inline Quat quat(const Array4& q) { return Quat(q[0], q[1], q[2], q[3]); }
inline Array3 array(const Vec3& v) { return {v.x(), v.y(), v.z()}; }
inline Array9 array(const Mat3& m) {
  return {m(0, 0), m(0, 1), m(0, 2), m(1, 0), m(1, 1), m(1, 2), m(2, 0), m(2, 1), m(2, 2)};
}

/// No time is later: 146 years, so that the difference of any two still fits.
inline constexpr std::int64_t kLatest_ns = 4'600'000'000'000'000'000;

/// Which parts of a sample were measured at its time. A part that was not is left at its default and never used.
enum SamplePart : std::uint8_t { kAcc = 1, kGyr = 2, kMag = 4, kTemp = 8 };
inline constexpr std::size_t kSampleParts = 4;
/// 0 to 3, in the order above: an index into arrays of one entry a part.
[[nodiscard]] constexpr std::size_t part_index(SamplePart part) noexcept {
  return static_cast<std::size_t>(std::countr_zero(static_cast<unsigned>(part)));
}

/// What the sensor gave at one time, any of its parts, as it gave it (bias and matrix not yet applied), in physical
/// units.
struct RawSample {
  std::int64_t t_ns = 0;       ///< time of the measurement, monotonic within a run
  std::uint64_t sequence = 0;  ///< counts samples from the source; a jump is a loss
  Array3 acc_mps2{};
  Array3 gyr_radps{};
  Array3 mag_uT{};
  double temp_degC = 0.0;
  std::uint8_t has = 0;  ///< bits of SamplePart

  [[nodiscard]] bool holds(SamplePart part) const noexcept { return (has & part) != 0; }
};

/// A reading after correction: u = H (y - B(T)). A type of its own, so that raw data cannot reach the filter.
struct CalibratedSample {
  std::int64_t t_ns = 0;
  std::uint64_t sequence = 0;
  Array3 acc_mps2{};
  Array3 gyr_radps{};
  Array3 mag_uT{};
  double temp_degC = 0.0;
  std::uint8_t has = 0;
  Array3 acc_turn_rad{};     ///< from the body at the accelerometer's reading to the body at t_ns, a rotation vector
  Array3 mag_turn_rad{};     ///< the same for the magnetometer; both zero for a reading of this very time
  std::uint8_t clipped = 0;  ///< bits of SamplePart: an axis of that part sits at the sensor's limit
  std::uint8_t absent = 0;   ///< bits of SamplePart: overdue; a part in neither `has` nor here only speaks more rarely
  std::uint64_t calibration_version = 0;

  [[nodiscard]] bool holds(SamplePart part) const noexcept { return (has & part) != 0; }
};

static_assert(std::is_trivially_copyable_v<RawSample> && std::is_trivially_copyable_v<CalibratedSample>);

}  // namespace stillpoint
