#include "calib_online/offline/rotation_fit.h"

#include <Eigen/Dense>
#include <cmath>

#include "core/so3.h"

namespace stillpoint::calib {

void NormalEquations::add(const MatX& J, const Vec3& r, double variance, int rank) {
  N += J.transpose() * J / variance;
  g += J.transpose() * r / variance;
  chi2 += r.squaredNorm() / variance;
  rows += rank;
}

double RotationFit::largest_sd_rad() const {
  return std::sqrt(Eigen::SelfAdjointEigenSolver<Mat3>(rotation_covariance()).eigenvalues()[2]);
}

RotationFit fit_rotation(const Mat3& start, const VecX& x_sd, const Residuals& residuals) {
  constexpr int kMostSteps = 60;
  constexpr double kDone = 1e-10, kLeastInformation = 1e-6, kMostDamping = 1e12;
  const Eigen::Index n = 3 + x_sd.size();
  const VecX prior = x_sd.cwiseAbs2().cwiseInverse();
  const auto sums_at = [&](const Mat3& R, const VecX& x) {
    NormalEquations sums(n);
    residuals(R, x, sums);
    return sums;
  };
  const auto cost = [&prior](const NormalEquations& sums, const VecX& x) {
    return sums.chi2 + x.cwiseAbs2().dot(prior);
  };
  RotationFit fit{start, VecX::Zero(x_sd.size()), {}, 0.0, 0};
  NormalEquations sums = sums_at(fit.R, fit.x);
  double damping = 1e-3;
  for (int step = 0; step < kMostSteps && damping < kMostDamping; ++step) {
    MatX N = sums.N;
    VecX g = sums.g;
    N.diagonal().tail(x_sd.size()) += prior;
    g.tail(x_sd.size()) += prior.cwiseProduct(fit.x);
    N.diagonal().array() *= 1.0 + damping;
    N.diagonal().array() += kLeastInformation;
    const VecX d = -N.ldlt().solve(g);
    const Mat3 R = exp_so3(d.head<3>()) * fit.R;
    const VecX x = fit.x + d.tail(x_sd.size());
    const NormalEquations next = sums_at(R, x);
    const double gain = cost(sums, fit.x) - cost(next, x);
    if (!(gain >= 0.0)) {
      damping *= 10.0;
      continue;
    }
    fit.R = R;
    fit.x = x;
    sums = next;
    damping = std::max(1e-9, 0.1 * damping);
    if (gain < kDone * (1.0 + sums.chi2)) break;
  }
  MatX information = sums.N;
  information.diagonal().tail(x_sd.size()) += prior;
  information.diagonal().head<3>().array() += kLeastInformation;
  fit.covariance = information.ldlt().solve(MatX::Identity(n, n));
  fit.chi2 = cost(sums, fit.x);
  fit.rows = sums.rows;
  return fit;
}

}  // namespace stillpoint::calib
