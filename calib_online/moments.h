/// The 35 sums m_abc = sum w x^a y^b z^c, a + b + c <= 4: all that LinAutoCalibration (both steps, repeated), every
/// algebraic ellipsoid fit, the noise-adjusted fit and the MAP fit need of the readings (docs/math/moments.md, M1-M6).
/// After Gietzelt et al., eqs. (11), (17); the vector as a design is ours.
/// Readings enter centred and scaled by the prior, x = (y - c0)/r0: raw counts lose eleven digits (M5).
#pragma once
#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <type_traits>

#include "core/types.h"

namespace stillpoint::calib {

/// Position of m_abc: by degree of x, then y, then z.
inline constexpr auto kMomentIndex = [] {
  std::array<std::array<std::array<signed char, 5>, 5>, 5> index{};
  signed char k = 0;
  for (std::size_t i = 0; i <= 4; ++i)
    for (std::size_t j = 0; i + j <= 4; ++j)
      for (std::size_t l = 0; i + j + l <= 4; ++l) index[i][j][l] = k++;
  return index;
}();
constexpr int moment_index(int a, int b, int c) noexcept {
  return kMomentIndex[static_cast<std::size_t>(a)][static_cast<std::size_t>(b)][static_cast<std::size_t>(c)];
}

class Moments {
 public:
  static constexpr int kCount = 35;
  using Mat10 = Eigen::Matrix<double, 10, 10>;

  /// w x^a y^b z^c to every sum.
  void add(const Vec3& x, double weight = 1.0) noexcept;
  /// The same, each monomial replaced by the one whose mean over noise of covariance C is the noise-free monomial (M4).
  void add_adjusted(const Vec3& x, const Mat3& C, double weight = 1.0) noexcept;
  void merge(const Moments& other) noexcept;
  void remove(const Moments& other) noexcept;
  void forget(double keep) noexcept;  ///< multiplies every sum

  /// Sums of x - d; exact (M2).
  [[nodiscard]] Moments translated(const Vec3& d) const noexcept;
  /// Sums of x / s, each axis by its own; exact (M3).
  [[nodiscard]] Moments scaled(const Vec3& s) const noexcept;
  /// All sums adjusted for one noise covariance (M4). Linear, so it may be done at the end.
  [[nodiscard]] Moments adjusted(const Mat3& C) const noexcept;

  [[nodiscard]] double at(int a, int b, int c) const noexcept {
    return m_[static_cast<std::size_t>(moment_index(a, b, c))];
  }
  [[nodiscard]] double weight() const noexcept { return m_[0]; }
  /// P = sum d d^T with d = (x^2, y^2, z^2, xy, xz, yz, x, y, z, 1) (M6).
  [[nodiscard]] Mat10 normal_matrix() const noexcept;
  [[nodiscard]] const std::array<double, kCount>& sums() const noexcept { return m_; }
  [[nodiscard]] static Moments of(const std::array<double, kCount>& sums) noexcept {
    Moments out;
    out.m_ = sums;
    return out;
  }

 private:
  std::array<double, kCount> m_{};
};

static_assert(sizeof(Moments) == 280 && std::is_trivially_copyable_v<Moments>);
static_assert(sizeof(Moments) <= 824, "the footprint of Gietzelt's implementation on the sensor node, section 4");

/// The running sums for a processor without doubles: each in single precision with what its roundings took (Kahan's
/// sum as Neumaier corrected it), 280 bytes. Good to 1e-5 counts where readings are centred and scaled (M5); a plain
/// single-precision sum is good to 2e-3. Fits are done on `widened()`.
class CompensatedMoments {
 public:
  void add(const Eigen::Vector3f& x, float weight = 1.0F) noexcept;
  void forget(float keep) noexcept;
  [[nodiscard]] Moments widened() const noexcept;

 private:
  std::array<float, Moments::kCount> sum_{}, lost_{};
};
static_assert(sizeof(CompensatedMoments) == 280 && std::is_trivially_copyable_v<CompensatedMoments>);

}  // namespace stillpoint::calib
