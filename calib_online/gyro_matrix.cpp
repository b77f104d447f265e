#include "calib_online/gyro_matrix.h"

#include <Eigen/Dense>
#include <cmath>

#include "core/so3.h"

namespace stillpoint::calib {
namespace {

Mat3 matrix(const Vec9& v) {
  Mat3 H;
  H << v.segment<3>(0).transpose(), v.segment<3>(3).transpose(), v.segment<3>(6).transpose();
  return H;
}

template <int kRows>
void accumulate(GyroMatrixSums& sums, const Eigen::Matrix<double, kRows, 9, Eigen::RowMajor>& M,
                const Eigen::Matrix<double, kRows, 1>& measured,
                const Eigen::Matrix<double, kRows, kRows>& covariance) {
  const Eigen::Matrix<double, kRows, kRows> W = covariance.inverse();
  const Mat9 N = M.transpose() * W * M;
  const Vec9 b = M.transpose() * W * measured;
  std::size_t k = 0;
  for (int i = 0; i < 9; ++i) {
    for (int j = 0; j <= i; ++j) sums.lower[k++] += N(i, j);
    sums.rhs[static_cast<std::size_t>(i)] += b[i];
  }
  ++sums.segments;
}

}  // namespace

Preintegrated preintegrate(const GyroSegment& segment, const Mat3& H) noexcept {
  Preintegrated p;
  for (const Vec3& z : segment.z) p.advance(z, H, segment.dt_s);
  return p;
}

void GyroMatrixSums::add_rotation(const Vec3& rotation_error, const Mat39& J, const Mat3& H_used,
                                  const Mat3& covariance) noexcept {
  accumulate<3>(*this, J, rotation_error + J * rows_of(H_used), covariance);
}

void GyroMatrixSums::add_direction(const Vec3& u_start, const Vec3& u_end, const Mat3& R, const Mat39& J,
                                   const Mat3& H_used, double direction_var, const Mat3& rotation_cov) noexcept {
  const Vec3 predicted = R.transpose() * u_start;
  const Mat3 lever = skew(predicted);  // R -> R exp(e) turns R^T u by -e: predicted + [predicted] e
  const Mat39 M = lever * J;
  const Mat3 covariance = 2.0 * direction_var * Mat3::Identity() + lever * rotation_cov * lever.transpose();
  accumulate<3>(*this, M, u_end - predicted + M * rows_of(H_used), covariance);
}

void GyroMatrixSums::add_angle(const Vec3& u, const Vec3& Z, double angle, double variance) noexcept {
  const Mat3 by_element = u * Z.transpose();
  using One = Eigen::Matrix<double, 1, 1>;
  accumulate<1>(*this, rows_of(by_element).transpose(), One(angle), One(variance));
}

void GyroMatrixSums::forget(double keep) noexcept {
  for (double& v : lower) v *= keep;
  for (double& v : rhs) v *= keep;
}

GyroMatrixFit solve(const GyroMatrixSums& sums, const Mat3& prior, double scale_sd, double cross_sd) noexcept {
  GyroMatrixFit fit;
  Mat9 N;
  Vec9 b;
  std::size_t k = 0;
  for (int i = 0; i < 9; ++i) {
    for (int j = 0; j <= i; ++j) N(i, j) = N(j, i) = sums.lower[k++];
    b[i] = sums.rhs[static_cast<std::size_t>(i)];
  }
  const Vec9 h0 = rows_of(prior);
  for (int i = 0; i < 9; ++i) {
    const double sd = i % 4 == 0 ? scale_sd : cross_sd;
    N(i, i) += 1.0 / (sd * sd);
    b[i] += h0[i] / (sd * sd);
  }
  const Eigen::LDLT<Mat9> solver(N);
  const Vec9 h = solver.solve(b);
  fit.covariance = solver.solve(Mat9::Identity());
  if (!h.allFinite() || !fit.covariance.allFinite()) {
    fit.status = FitStatus::kNotObservable;
    return fit;
  }
  fit.H = matrix(h);
  return fit;
}

Mat3 gyro_matrix_gauss_newton(std::span<const GyroSegment> segments, const Mat3& H0, int iterations) {
  Mat3 H = H0;
  for (int k = 0; k < iterations; ++k) {
    Mat9 N = Mat9::Zero();
    Vec9 b = Vec9::Zero();
    for (const auto& s : segments) {
      const Preintegrated p = preintegrate(s, H);
      const Vec3 e = log_quat(p.q.conjugate() * s.reference);
      N += p.J.transpose() * p.J;
      b += p.J.transpose() * e;
    }
    const Vec9 step = N.ldlt().solve(b);
    if (!step.allFinite()) break;
    H += matrix(step);
  }
  return H;
}

Mat3 gyro_matrix_ukf(std::span<const GyroSegment> segments, const Mat3& H0, int passes, double alpha,
                     double process_var, double measurement_var) {
  constexpr int n = 9;
  const auto m = 4 * static_cast<Eigen::Index>(segments.size());
  const auto coefficients = [](const Quat& q) { return Eigen::Vector4d(q.w(), q.x(), q.y(), q.z()); };
  const auto predict = [&](const Vec9& h) {
    Eigen::VectorXd out(m);
    for (std::size_t j = 0; j < segments.size(); ++j) {
      // Each predicted quaternion on the side of its reference: q and -q are one rotation but not one measurement.
      Eigen::Vector4d q = coefficients(preintegrate(segments[j], matrix(h)).q);
      if (q.dot(coefficients(segments[j].reference)) < 0.0) q = -q;
      out.segment<4>(4 * static_cast<Eigen::Index>(j)) = q;
    }
    return out;
  };
  Eigen::VectorXd measured(m);
  for (std::size_t j = 0; j < segments.size(); ++j)
    measured.segment<4>(4 * static_cast<Eigen::Index>(j)) = coefficients(segments[j].reference);

  const double lambda = alpha * alpha * n - n;
  const double w_side = 0.5 / (n + lambda), w_mean = lambda / (n + lambda);
  const double w_cov = w_mean + 1.0 - alpha * alpha + 2.0;
  Vec9 x = rows_of(H0);
  Mat9 P = process_var * Mat9::Identity();
  for (int pass = 0; pass < passes; ++pass) {
    P += process_var * Mat9::Identity();  // (Z 44)
    const Mat9 root = Mat9(((n + lambda) * P).llt().matrixL());
    std::vector<Vec9> points{x};
    for (int k = 0; k < n; ++k) {
      points.emplace_back(x + root.col(k));
      points.emplace_back(x - root.col(k));
    }
    std::vector<Eigen::VectorXd> out;
    Eigen::VectorXd mean = Eigen::VectorXd::Zero(m);
    for (std::size_t k = 0; k < points.size(); ++k) {
      out.push_back(predict(points[k]));
      mean += (k == 0 ? w_mean : w_side) * out.back();
    }
    Eigen::MatrixXd S = measurement_var * Eigen::MatrixXd::Identity(m, m);
    Eigen::MatrixXd cross = Eigen::MatrixXd::Zero(n, m);
    for (std::size_t k = 0; k < points.size(); ++k) {
      const double w = k == 0 ? w_cov : w_side;
      S += w * (out[k] - mean) * (out[k] - mean).transpose();
      cross += w * (points[k] - x) * (out[k] - mean).transpose();
    }
    const Eigen::MatrixXd gain = S.ldlt().solve(cross.transpose()).transpose();
    x += gain * (measured - mean);
    P -= gain * S * gain.transpose();
    P = (0.5 * (P + P.transpose())).eval();
    // Rounding: the paper's measurement noise is 1e-7, far below what 36 numbers of size one leave of P.
    P.diagonal().array() += 1e-12;
  }
  return matrix(x);
}

}  // namespace stillpoint::calib
