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

template <class T>
class BasicMoments {
 public:
  static constexpr int kCount = 35;
  using Mat10 = Eigen::Matrix<T, 10, 10>;

  /// w x^a y^b z^c to every sum.
  void add(const Eigen::Matrix<T, 3, 1>& x, T weight = T(1)) noexcept;
  /// The same, each monomial replaced by the one whose mean over noise of covariance C is the noise-free monomial (M4).
  void add_adjusted(const Eigen::Matrix<T, 3, 1>& x, const Eigen::Matrix<T, 3, 3>& C, T weight = T(1)) noexcept;
  void merge(const BasicMoments& other) noexcept;
  void remove(const BasicMoments& other) noexcept;
  void forget(T keep) noexcept;  ///< multiplies every sum

  /// Sums of x - d; exact (M2).
  [[nodiscard]] BasicMoments translated(const Eigen::Matrix<T, 3, 1>& d) const noexcept;
  /// Sums of x / s, each axis by its own; exact (M3).
  [[nodiscard]] BasicMoments scaled(const Eigen::Matrix<T, 3, 1>& s) const noexcept;
  /// All sums adjusted for one noise covariance (M4). Linear, so it may be done at the end.
  [[nodiscard]] BasicMoments adjusted(const Eigen::Matrix<T, 3, 3>& C) const noexcept;

  [[nodiscard]] T at(int a, int b, int c) const noexcept { return m_[static_cast<std::size_t>(moment_index(a, b, c))]; }
  [[nodiscard]] T weight() const noexcept { return m_[0]; }
  /// P = sum d d^T with d = (x^2, y^2, z^2, xy, xz, yz, x, y, z, 1) (M6).
  [[nodiscard]] Mat10 normal_matrix() const noexcept;
  [[nodiscard]] const std::array<T, kCount>& sums() const noexcept { return m_; }

 private:
  std::array<T, kCount> m_{};
};

using Moments = BasicMoments<double>;
static_assert(sizeof(Moments) == 280 && std::is_trivially_copyable_v<Moments>);
static_assert(sizeof(Moments) <= 824, "the footprint of Gietzelt's implementation on the sensor node, section 4");

extern template class BasicMoments<double>;
extern template class BasicMoments<float>;

}  // namespace stillpoint::calib
