#include "calib_online/moments.h"

#include <cmath>

namespace stillpoint::calib {
namespace {

struct Exponents {
  int a, b, c;
};

constexpr std::array<Exponents, 35> all_exponents() {
  std::array<Exponents, 35> e{};
  std::size_t k = 0;
  for (int a = 0; a <= 4; ++a)
    for (int b = 0; a + b <= 4; ++b)
      for (int c = 0; a + b + c <= 4; ++c) e[k++] = {a, b, c};
  return e;
}
constexpr auto kExponents = all_exponents();
/// Of d = (x^2, y^2, z^2, xy, xz, yz, x, y, z, 1).
constexpr std::array<Exponents, 10> kTerms{
    {{2, 0, 0}, {0, 2, 0}, {0, 0, 2}, {1, 1, 0}, {1, 0, 1}, {0, 1, 1}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 0}}};

constexpr auto normal_indices() {
  std::array<std::array<std::size_t, 10>, 10> index{};
  for (std::size_t i = 0; i < 10; ++i)
    for (std::size_t j = 0; j < 10; ++j)
      index[i][j] = static_cast<std::size_t>(
          moment_index(kTerms[i].a + kTerms[j].a, kTerms[i].b + kTerms[j].b, kTerms[i].c + kTerms[j].c));
  return index;
}
constexpr auto kNormalIndex = normal_indices();

constexpr std::array<std::array<int, 5>, 5> kBinomial{
    {{1, 0, 0, 0, 0}, {1, 1, 0, 0, 0}, {1, 2, 1, 0, 0}, {1, 3, 3, 1, 0}, {1, 4, 6, 4, 1}}};

template <class T>
std::array<std::array<T, 5>, 3> powers(const Eigen::Matrix<T, 3, 1>& x) {
  std::array<std::array<T, 5>, 3> p;
  for (int axis = 0; axis < 3; ++axis) {
    auto& q = p[static_cast<std::size_t>(axis)];
    q[0] = T(1);
    for (std::size_t k = 1; k < 5; ++k) q[k] = q[k - 1] * x[axis];
  }
  return p;
}

/// L m = sum_ij C_ij d_i d_j acting on the monomials.
std::array<double, 35> heat(const std::array<double, 35>& m, const Mat3& C) {
  std::array<double, 35> out{};
  for (std::size_t k = 0; k < 35; ++k) {
    const std::array<int, 3> e{kExponents[k].a, kExponents[k].b, kExponents[k].c};
    double sum = 0.0;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        std::array<int, 3> f = e;
        const int first = f[static_cast<std::size_t>(i)]--;
        const int second = f[static_cast<std::size_t>(j)]--;
        if (first < 1 || second < 1) continue;
        sum +=
            C(i, j) * static_cast<double>(first * second) * m[static_cast<std::size_t>(moment_index(f[0], f[1], f[2]))];
      }
    }
    out[k] = sum;
  }
  return out;
}

}  // namespace

void Moments::add(const Vec3& x, double weight) noexcept {
  const auto p = powers(x);
  for (std::size_t k = 0; k < 35; ++k) {
    const Exponents& e = kExponents[k];
    m_[k] += weight * p[0][static_cast<std::size_t>(e.a)] * p[1][static_cast<std::size_t>(e.b)] *
             p[2][static_cast<std::size_t>(e.c)];
  }
}

void Moments::add_adjusted(const Vec3& x, const Mat3& C, double weight) noexcept {
  Moments one;
  one.add(x, weight);
  merge(one.adjusted(C));
}

void Moments::merge(const Moments& other) noexcept {
  for (std::size_t k = 0; k < 35; ++k) m_[k] += other.m_[k];
}

void Moments::remove(const Moments& other) noexcept {
  for (std::size_t k = 0; k < 35; ++k) m_[k] -= other.m_[k];
}

void Moments::forget(double keep) noexcept {
  for (double& m : m_) m *= keep;
}

Moments Moments::translated(const Vec3& d) const noexcept {
  const auto p = powers(Vec3(-d));
  Moments out;
  for (std::size_t k = 0; k < 35; ++k) {
    const Exponents& e = kExponents[k];
    double sum = 0.0;
    for (int i = 0; i <= e.a; ++i)
      for (int j = 0; j <= e.b; ++j)
        for (int l = 0; l <= e.c; ++l) {
          const auto at = [](int v) { return static_cast<std::size_t>(v); };
          const int ways = kBinomial[at(e.a)][at(i)] * kBinomial[at(e.b)][at(j)] * kBinomial[at(e.c)][at(l)];
          sum += static_cast<double>(ways) * p[0][at(e.a - i)] * p[1][at(e.b - j)] * p[2][at(e.c - l)] *
                 m_[at(moment_index(i, j, l))];
        }
    out.m_[k] = sum;
  }
  return out;
}

Moments Moments::scaled(const Vec3& s) const noexcept {
  const auto p = powers(Vec3(s.cwiseInverse()));
  Moments out;
  for (std::size_t k = 0; k < 35; ++k) {
    const Exponents& e = kExponents[k];
    out.m_[k] = m_[k] * p[0][static_cast<std::size_t>(e.a)] * p[1][static_cast<std::size_t>(e.b)] *
                p[2][static_cast<std::size_t>(e.c)];
  }
  return out;
}

Moments Moments::adjusted(const Mat3& C) const noexcept {
  // exp(-L/2) = 1 - L/2 + L^2/8: L lowers the degree by two, so degree four ends there.
  const auto once = heat(m_, C);
  const auto twice = heat(once, C);
  Moments out;
  for (std::size_t k = 0; k < 35; ++k) out.m_[k] = m_[k] - once[k] / 2.0 + twice[k] / 8.0;
  return out;
}

Moments::Mat10 Moments::normal_matrix() const noexcept {
  Mat10 P;
  for (std::size_t i = 0; i < 10; ++i)
    for (std::size_t j = 0; j < 10; ++j) P(static_cast<int>(i), static_cast<int>(j)) = m_[kNormalIndex[i][j]];
  return P;
}

void CompensatedMoments::add(const Eigen::Vector3f& x, float weight) noexcept {
  const auto p = powers(x);
  for (std::size_t k = 0; k < 35; ++k) {
    const Exponents& e = kExponents[k];
    const float term = weight * p[0][static_cast<std::size_t>(e.a)] * p[1][static_cast<std::size_t>(e.b)] *
                       p[2][static_cast<std::size_t>(e.c)];
    const float sum = sum_[k] + term;
    // The smaller of the two lost its low digits.
    lost_[k] += std::abs(sum_[k]) >= std::abs(term) ? (sum_[k] - sum) + term : (term - sum) + sum_[k];
    sum_[k] = sum;
  }
}

void CompensatedMoments::forget(float keep) noexcept {
  for (std::size_t k = 0; k < 35; ++k) {
    // The product's own rounding is kept as well, or forgetting at every reading would undo the compensation.
    const float kept = sum_[k] * keep;
    lost_[k] = lost_[k] * keep + std::fma(sum_[k], keep, -kept);
    sum_[k] = kept;
  }
}

Moments CompensatedMoments::widened() const noexcept {
  std::array<double, 35> sums{};
  for (std::size_t k = 0; k < 35; ++k) sums[k] = static_cast<double>(sum_[k]) + static_cast<double>(lost_[k]);
  return Moments::of(sums);
}

}  // namespace stillpoint::calib
