#include "calib_online/map_fit.h"

#include <Eigen/Dense>
#include <cmath>

namespace stillpoint::calib {

MapFit map_fit(const Moments& m, double norm_sd, const MapPrior& prior) noexcept {
  MapFit fit;
  const Moments::Mat10 P = m.normal_matrix();
  const double per_window = 1.0 / (4.0 * norm_sd * norm_sd);
  const auto variance = [](double sd) { return 4.0 * sd * sd; };
  Vec9 prior_information;
  prior_information << Vec3::Constant(1.0 / variance(prior.scale_sd)), Vec3::Constant(1.0 / variance(prior.shear_sd)),
      Vec3::Constant(1.0 / variance(prior.centre_sd));
  Vec9 p0 = Vec9::Zero();
  p0.head<3>().setOnes();
  // Adjustment may leave the sums indefinite; the deficit is added back to what is known beforehand, about the same p0.
  const Mat9 seen = per_window * P.topLeftCorner<9, 9>();
  const double least =
      Eigen::SelfAdjointEigenSolver<Mat9>(seen + Mat9(prior_information.asDiagonal()), Eigen::EigenvaluesOnly)
          .eigenvalues()[0];
  const double floor = 0.5 * prior_information.minCoeff();
  if (least < floor) prior_information.array() += floor - least;
  const Eigen::LDLT<Mat9> solver(seen + Mat9(prior_information.asDiagonal()));
  fit.p = solver.solve(Vec9(per_window * P.block<9, 1>(0, 9) + prior_information.cwiseProduct(p0)));
  fit.covariance = solver.solve(Mat9::Identity());
  const auto e = ellipsoid(fit.p);
  if (!e || !fit.covariance.allFinite()) {
    fit.status = FitStatus::kNotPositiveDefinite;
    return fit;
  }
  fit.ellipsoid = *e;
  fit.norm_sd = std::sqrt(mean_norm_variance(fit.covariance));
  const WorstDirection worst = worst_norm_variance(fit.covariance);
  fit.worst_norm_sd = std::sqrt(worst.variance);
  fit.worst_direction = worst.direction;
  return fit;
}

}  // namespace stillpoint::calib
