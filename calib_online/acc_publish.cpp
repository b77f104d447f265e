// From the entries of the ellipsoid to what AccLearner publishes.
#include <Eigen/Dense>
#include <cmath>

#include "calib_online/acc_learner.h"

namespace stillpoint::calib {

void AccLearner::publish(double temp_degC, const SeenTemperatures& seen, TriadCalibration& out) noexcept {
  const double g = params_.gravity_mps2;
  const double t = tau(temp_degC);
  const Estimate known = doubted(temp_degC);
  const auto here = known.valid ? ellipsoid(known.p) : std::nullopt;
  // Worse than the prior on the windows themselves: the factory values serve until that is over.
  const bool worse = s_.error_weight > 5.0 && s_.learnt_error > 1.2 * s_.factory_error;
  if (!here || worse) {
    out = factory_;
    out.windows = s_.windows;
    out.status = !here              ? CalibrationStatus::kNotPositiveDefinite
                 : s_.replaced != 0 ? CalibrationStatus::kReplaced
                                    : CalibrationStatus::kFactory;
    return;
  }
  const Mat3 H_f = mat(factory_.matrix);
  const Mat3 to_reading = g * H_f.inverse();
  // The centre at three temperatures gives the polynomial of the bias; the matrix is that of now.
  const double step = 0.2;  // 5 K
  const auto colder = ellipsoid(entries(temp_degC - step * kTempScale_K)),
             warmer = ellipsoid(entries(temp_degC + step * kTempScale_K));
  const Vec3 c0 = here->centre;
  const Vec3 c1 = colder && warmer ? Vec3((warmer->centre - colder->centre) / (2.0 * step)) : Vec3(Vec3::Zero());
  const Vec3 c2 =
      colder && warmer ? Vec3((warmer->centre - 2.0 * c0 + colder->centre) / (2.0 * step * step)) : Vec3(Vec3::Zero());
  const double s = kTempScale_K;
  out.matrix = array(Mat3(here->K * H_f));
  out.bias = array(Vec3(vec(factory_.bias) + to_reading * (c0 - t * c1 + t * t * c2)));
  out.bias_per_K = array(Vec3(vec(factory_.bias_per_K) + to_reading * (c1 - 2.0 * t * c2) / s));
  out.bias_per_K2 = array(Vec3(vec(factory_.bias_per_K2) + to_reading * c2 / (s * s)));
  out.temp_ref_degC = factory_.temp_ref_degC;
  out.temp_min_degC = seen.min_degC;
  out.temp_max_degC = seen.max_degC;
  const Mat9& C = known.covariance;
  out.bias_covariance = array(Mat3(0.25 * to_reading * C.bottomRightCorner<3, 3>() * to_reading.transpose()));
  out.norm_sd = g * std::sqrt(mean_norm_variance(C));
  out.windows = s_.windows;
  const Mat9 C0 = published_.prior_covariance_at(t);
  // Twice as good as the prior in the mean, even where it is worst.
  const bool learnt = worst_norm_variance(C).variance < 0.3 * mean_norm_variance(C0);
  if (learnt && !rivalry_.is_open()) s_.replaced = 0;
  out.status = s_.replaced != 0 ? CalibrationStatus::kReplaced
               : learnt         ? CalibrationStatus::kOk
                        : (s_.windows < 12 ? CalibrationStatus::kTooFewWindows : CalibrationStatus::kNotObservable);
}

}  // namespace stillpoint::calib
