#include "calib_online/offline/ellipsoid_fit.h"

#include <Eigen/Dense>
#include <cmath>
#include <optional>

namespace stillpoint::calib {
namespace {

constexpr double kSingular = 1e-10;  // smallest over largest eigenvalue of a normal matrix that still observes

using Mat4 = Eigen::Matrix4d;
using Mat10 = Moments::Mat10;
using Vec10 = Eigen::Matrix<double, 10, 1>;

/// Step 1, (G 11): centre and rms radius of a sphere. Empty when the points lie in a plane.
std::optional<Eigen::Vector4d> sphere(const Moments& m) {
  Mat4 N;
  N << m.at(0, 0, 0), m.at(1, 0, 0), m.at(0, 1, 0), m.at(0, 0, 1),  //
      m.at(1, 0, 0), m.at(2, 0, 0), m.at(1, 1, 0), m.at(1, 0, 1),   //
      m.at(0, 1, 0), m.at(1, 1, 0), m.at(0, 2, 0), m.at(0, 1, 1),   //
      m.at(0, 0, 1), m.at(1, 0, 1), m.at(0, 1, 1), m.at(0, 0, 2);
  const Eigen::Vector4d rhs(
      -(m.at(2, 0, 0) + m.at(0, 2, 0) + m.at(0, 0, 2)), -(m.at(3, 0, 0) + m.at(1, 2, 0) + m.at(1, 0, 2)),
      -(m.at(2, 1, 0) + m.at(0, 3, 0) + m.at(0, 1, 2)), -(m.at(2, 0, 1) + m.at(0, 2, 1) + m.at(0, 0, 3)));
  const Eigen::SelfAdjointEigenSolver<Mat4> eigen(N);
  if (!(eigen.eigenvalues()[0] > kSingular * eigen.eigenvalues()[3])) return std::nullopt;
  const Eigen::Vector4d abcd = N.ldlt().solve(rhs);
  const Vec3 centre = -0.5 * abcd.tail<3>();
  Eigen::Vector4d out;
  out << centre, std::sqrt(std::max(0.0, centre.squaredNorm() - abcd[0]));  // (G 12)
  return out;
}

/// Step 2, (G 17), about the centre: 1/s^2 per axis. Empty when the squares are not independent.
std::optional<Vec3> inverse_square_radii(const Moments& m) {
  Mat3 N;
  N << m.at(4, 0, 0), m.at(2, 2, 0), m.at(2, 0, 2), m.at(2, 2, 0), m.at(0, 4, 0), m.at(0, 2, 2), m.at(2, 0, 2),
      m.at(0, 2, 2), m.at(0, 0, 4);
  const Eigen::SelfAdjointEigenSolver<Mat3> eigen(N);
  if (!(eigen.eigenvalues()[0] > kSingular * eigen.eigenvalues()[2])) return std::nullopt;
  return Vec3(N.ldlt().solve(Vec3(m.at(2, 0, 0), m.at(0, 2, 0), m.at(0, 0, 2))));
}

/// p with |p| = 1 and constant term p10 to d9^T p = 1.
GeneralFit from_null_vector(const Vec10& v) {
  GeneralFit fit;
  fit.status = FitStatus::kNotPositiveDefinite;
  if (std::abs(v[9]) < 1e-12) return fit;
  if (const auto e = ellipsoid(Vec9(v.head<9>() / -v[9]))) {
    fit.ellipsoid = *e;
    fit.status = FitStatus::kOk;
  }
  return fit;
}

}  // namespace

AxisFit lin_auto(const Moments& m, int passes) noexcept {
  AxisFit fit;
  for (int pass = 0; pass < passes; ++pass) {
    const Moments in = m.scaled(fit.radii);
    const auto step1 = sphere(in);
    if (!step1) return {};
    const auto t = inverse_square_radii(in.translated(step1->head<3>()));
    if (!t) return {};
    for (int k = 0; k < 3; ++k) {
      if ((*t)[k] > 0.0) continue;
      AxisFit failed;
      failed.unobserved_axis = k;
      return failed;
    }
    fit.centre = step1->head<3>().cwiseProduct(fit.radii);
    fit.sphere_radius = (*step1)[3];
    fit.radii = fit.radii.cwiseProduct(t->cwiseInverse().cwiseSqrt());
  }
  fit.status = FitStatus::kOk;
  return fit;
}

GeneralFit general_fit(const Moments& m) noexcept { return adjusted_fit(m, 0.0); }

GeneralFit adjusted_fit(const Moments& m, double noise_variance) noexcept {
  if (m.weight() < 9.0) return {FitStatus::kTooFewPoints, {}, 0.0};
  const auto eigen_at = [&m](double s) {
    return Eigen::SelfAdjointEigenSolver<Mat10>(m.adjusted(Mat3(s * Mat3::Identity())).normal_matrix());
  };
  const auto plain = eigen_at(0.0);
  if (!(plain.eigenvalues()[1] > kSingular * plain.eigenvalues()[9])) return {};
  double s = noise_variance;
  if (s < 0.0) {
    // The smallest eigenvalue falls with s; where it is zero the adjusted matrix has an exact null vector.
    double low = 0.0, high = 0.25;
    if (eigen_at(high).eigenvalues()[0] > 0.0) return {};
    for (int k = 0; k < 60; ++k) {
      const double middle = 0.5 * (low + high);
      (eigen_at(middle).eigenvalues()[0] > 0.0 ? low : high) = middle;
    }
    s = low;
  }
  GeneralFit fit =
      from_null_vector(s == 0.0 ? Vec10(plain.eigenvectors().col(0)) : Vec10(eigen_at(s).eigenvectors().col(0)));
  fit.noise_variance = s;
  return fit;
}

}  // namespace stillpoint::calib
