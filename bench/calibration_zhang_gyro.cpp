/// Table II of Zhang, the gyroscope's matrix, and the effect of Table III, the mounting.
#include <Eigen/Dense>
#include <cstdio>
#include <unsupported/Eigen/NonLinearOptimization>
#include <unsupported/Eigen/NumericalDiff>

#include "bench/calibration_tables.h"
#include "calib_online/gyro_matrix.h"
#include "calib_online/offline/two_step.h"

namespace stillpoint::bench {
namespace {

struct Trust {
  using Scalar = double;
  enum { InputsAtCompileTime = Eigen::Dynamic, ValuesAtCompileTime = Eigen::Dynamic };
  using InputType = Eigen::VectorXd;
  using ValueType = Eigen::VectorXd;
  using JacobianType = Eigen::MatrixXd;
  const std::vector<calib::GyroSegment>* segments;
  int inputs() const { return 9; }
  int values() const { return 4 * static_cast<int>(segments->size()); }
  int operator()(const Eigen::VectorXd& h, Eigen::VectorXd& r) const {
    const Mat3 H = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(h.data());
    for (std::size_t j = 0; j < segments->size(); ++j) {
      const Quat q = calib::preintegrate((*segments)[j], H).q, ref = (*segments)[j].reference;
      const double sign = q.dot(ref) < 0 ? -1.0 : 1.0;
      r.segment<4>(4 * static_cast<Eigen::Index>(j)) = sign * q.coeffs() - ref.coeffs();
    }
    return 0;
  }
};

std::vector<calib::GyroSegment> segments(Random& random, const Mat3& H_true, double noise_radps) {
  std::vector<calib::GyroSegment> out;
  const Mat3 H_inv = H_true.inverse();
  for (int j = 0; j < 9; ++j) {
    calib::GyroSegment s;
    s.dt_s = 0.01;
    const Vec3 rate = random.direction() * random.uniform(0.5, 1.4);  // 1 to 2.8 rad in 2 s
    Quat q = Quat::Identity();
    for (int k = 0; k < 200; ++k) {
      const Vec3 u = rate * (1.0 + 0.5 * std::sin(0.0314 * k));
      s.z.push_back(H_inv * u + random.normal3(noise_radps));
      q = q * exp_quat(u * s.dt_s);
    }
    s.reference = q.normalized();
    out.push_back(s);
  }
  return out;
}

/// A matrix with 10 % of spread about the identity (3 sd).
Mat3 draw_matrix(Random& random) {
  Mat3 H = Mat3::Identity();
  for (int k = 0; k < 9; ++k) H(k / 3, k % 3) += random.normal(0.1 / 3.0);
  return H;
}

Mat3 by_trust_region(const std::vector<calib::GyroSegment>& s, int passes) {
  Trust f{&s};
  Eigen::NumericalDiff<Trust> df(f);
  Eigen::LevenbergMarquardt<Eigen::NumericalDiff<Trust>> lm(df);
  lm.parameters.maxfev = 10 * passes;
  Eigen::VectorXd h(9);
  h << 1, 0, 0, 0, 1, 0, 0, 0, 1;
  lm.minimize(h);
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(h.data());
}

/// Errors of each method's matrix after some passes: 300 runs, of the slow trust region 50.
struct MatrixErrors {
  std::vector<double> ukf, narrow_ukf, gauss_newton, trust_region;
};
MatrixErrors matrix_errors(int passes) {
  MatrixErrors e;
  Random random(2);
  const Mat3 start = Mat3::Identity();
  for (int run = 0; run < 300; ++run) {
    const Mat3 H = draw_matrix(random);
    const auto s = segments(random, H, 0.05);
    e.ukf.push_back((calib::gyro_matrix_ukf(s, start, passes, 1.0) - H).norm());
    e.narrow_ukf.push_back((calib::gyro_matrix_ukf(s, start, passes, 1e-3) - H).norm());
    e.gauss_newton.push_back((calib::gyro_matrix_gauss_newton(s, start, passes) - H).norm());
    if (run < 50) e.trust_region.push_back((by_trust_region(s, passes) - H).norm());
  }
  return e;
}

void print_those_that_end_well(const std::vector<double>& errors) {
  std::vector<double> good;
  for (double x : errors)
    if (x < 0.5) good.push_back(x);
  std::printf("   %.4f (%5.1f %%)", mean(good),
              100.0 * static_cast<double>(good.size()) / static_cast<double>(errors.size()));
}

void table2(Figures& figures) {
  std::printf(
      "\nTable II, |H_g - H^_g|, 9 segments of 2 s at 100 Hz, noise sd 0.05 rad/s, H_g = I + 10 %%, 300 runs, seed 2; "
      "mean of the runs that end below 0.5 (share)\n");
  std::printf("%-14s %12s %18s %18s %18s %16s\n", "after", "paper (UKF)", "UKF alpha 1", "UKF alpha 1e-3",
              "Gauss-Newton", "trust region");
  const int passes[4] = {2, 5, 10, 20};
  const double paper[4] = {1.1261, 0.0058, 0.0045, 0.0045};
  for (int p = 0; p < 4; ++p) {
    const MatrixErrors e = matrix_errors(passes[p]);
    std::printf("%-14d %12.4f", passes[p], paper[p]);
    for (const auto* errors : {&e.ukf, &e.narrow_ukf, &e.gauss_newton, &e.trust_region})
      print_those_that_end_well(*errors);
    std::printf("\n");
    figures["table2.gauss_newton_after_" + std::to_string(passes[p])] = mean(e.gauss_newton);
  }
}

void print_far_start() {
  int diverged_ukf = 0, diverged_gn = 0;
  Random random(4);
  for (int run = 0; run < 300; ++run) {
    const Mat3 H = draw_matrix(random);
    const auto s = segments(random, H, 0.05);
    const Mat3 H0 = 1.5 * exp_so3(20 * kRadPerDeg * random.direction()) * H;
    diverged_ukf += !((calib::gyro_matrix_ukf(s, H0, 10, 1.0) - H).norm() < 0.1);
    diverged_gn += !((calib::gyro_matrix_gauss_newton(s, H0, 10) - H).norm() < 0.1);
  }
  std::printf(
      "from a start 50 %% / 20 degrees off, not within 0.1 after 10: UKF %.0f %%, Gauss-Newton %.0f %% of 300 runs\n",
      diverged_ukf / 3.0, diverged_gn / 3.0);
}

/// Attitude from gravity and field (TRIAD) with the field turned by H: rms error over 20 attitudes, rad.
double triad_error(Random& random, const Mat3& mount, const Vec3& field, const Mat3& H) {
  std::vector<double> e;
  for (int k = 0; k < 20; ++k) {
    const Mat3 Q = random.rotation().toRotationMatrix();
    const Vec3 a = Q * Vec3(0, 0, 9.81), m = H * (mount.transpose() * (Q * field));
    const Vec3 up = a.normalized(), east = m.cross(up).normalized();
    Mat3 seen;
    seen << east, up.cross(east), up;
    e.push_back(log_so3(Mat3(Q.transpose() * seen)).norm());
  }
  return rms(e);
}

void table3(Figures& figures) {
  // Attitude by gravity and field (TRIAD), with the mounting angle between the two sensors calibrated or not.
  Random random(5);
  std::vector<double> with, without;
  for (int run = 0; run < 200; ++run) {
    const Mat3 mount = exp_so3(random.normal3(3.0 * kRadPerDeg));
    calib::TwoStepSums sums;
    const Vec3 field(0, 20, -43);
    for (int j = 0; j < 20; ++j) {
      const Mat3 Rj = j == 0 ? Mat3(Mat3::Identity()) : random.rotation().toRotationMatrix();
      sums.add(mount.transpose() * (Rj * field + random.normal3(0.1)), Rj);
    }
    const auto fit = calib::two_step_closed(sums, field.norm(), Mat3::Identity());
    with.push_back(triad_error(random, mount, field, fit.H));
    without.push_back(triad_error(random, mount, field, Mat3::Identity()));
  }
  std::printf(
      "\nTable III, effect of the mounting calibration on simulated data (3 deg a axis, 200 runs, seed 5), rms "
      "attitude error, rad\n"
      "  with %.4f (paper .004-.007), without %.4f (paper .041-.063); ratio %.1f (paper about 10)\n",
      rms(with), rms(without), rms(without) / rms(with));
  figures["table3.ratio"] = rms(without) / rms(with);
}

}  // namespace

void zhang_gyro_tables(Figures& figures) {
  table2(figures);
  print_far_start();
  table3(figures);
}

}  // namespace stillpoint::bench
