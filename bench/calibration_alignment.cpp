/// Angle between triads from the gyroscope's own rotations, chained and pairwise.
#include <Eigen/Dense>
#include <cstdio>

#include "bench/calibration_tables.h"
#include "calib_online/alignment.h"
#include "calib_online/two_step.h"

namespace stillpoint::bench {
namespace {

struct Gyro {
  const char* name;
  double bias_dps, scale, noise_dps_rtHz;
};

struct Errors {
  std::vector<double> pairwise, chained, ratio;
  int refused = 0;
};

Errors run(const Gyro& gyro, bool one_axis, int windows, int runs) {
  Errors out;
  Random random(77);
  for (int k = 0; k < runs; ++k) {
    const Vec3 misaligned = random.normal3(1.0 * kRadPerDeg);
    const Mat3 O = exp_so3(misaligned);  // triad axes into gyro axes
    const Vec3 bias = gyro.bias_dps * kRadPerDeg * random.direction();
    Mat3 scale = Mat3::Identity();
    for (int i = 0; i < 3; ++i) scale(i, i) += random.normal(gyro.scale);
    calib::PairwiseSums pairs;
    calib::TwoStepSums chain;
    Quat q_world_body = random.rotation();
    Mat3 R_now_first = Mat3::Identity();
    Vec3 before = Vec3::Zero();
    for (int w = 0; w < windows; ++w) {
      Mat3 R_measured = Mat3::Identity();  // previous from this
      const double seconds = 3.0;
      double angle = 0.0;
      if (w > 0) {
        const Vec3 turn = (one_axis ? Vec3(0.6, 0, 0.8) : random.direction()) * random.uniform(0.7, 2.2);
        angle = turn.norm();
        q_world_body = q_world_body * exp_quat(turn);
        R_measured = exp_so3(scale * turn + seconds * bias +
                             random.normal3(gyro.noise_dps_rtHz * kRadPerDeg * std::sqrt(seconds)));
      }
      const Vec3 up = O.transpose() * (q_world_body.conjugate() * Vec3::UnitZ()) + random.normal3(0.0005);
      R_now_first = R_measured.transpose() * R_now_first;
      chain.add(up, R_now_first);
      if (w > 0) {
        const double sd =
            std::sqrt(std::pow(seconds * gyro.bias_dps * kRadPerDeg, 2) / 3 + std::pow(gyro.scale * angle, 2) / 3 +
                      std::pow(gyro.noise_dps_rtHz * kRadPerDeg, 2) * seconds);
        pairs.add(before, up, R_measured, 0.0005 * 0.0005, Mat3(sd * sd * Mat3::Identity()));
      }
      before = up;
    }
    const auto a = calib::align(pairs, Mat3::Identity());
    if (a.status != calib::FitStatus::kOk) {
      ++out.refused;
      continue;
    }
    const double e = log_so3(Mat3(a.R_gyr_triad * O.transpose())).norm() * kDegPerRad;
    out.pairwise.push_back(e);
    out.ratio.push_back(std::sqrt(a.covariance.trace()) * kDegPerRad);
    const auto absolute = calib::two_step_closed(chain, 1.0, Mat3::Identity());
    const Eigen::JacobiSVD<Mat3> svd(absolute.H, Eigen::ComputeFullU | Eigen::ComputeFullV);
    out.chained.push_back(log_so3(Mat3(svd.matrixU() * svd.matrixV().transpose() * O.transpose())).norm() * kDegPerRad);
  }
  return out;
}

}  // namespace

Figures alignment_and_gyro() {
  Figures figures;
  std::printf(
      "\n== Misalignment between triads, 24 windows, turns of 40 to 126 deg in 3 s, 1 mrad of direction noise a pair; "
      "rms of 300 runs, seed 77, deg ==\n");
  std::printf("%-46s %10s %12s %18s\n", "gyro", "pairwise", "predicted sd", "chained (Zhang)");
  for (const Gyro& g : {Gyro{"good: 0.005 deg/s, 0.05 %, 0.005 deg/s/rtHz", 0.005, 0.0005, 0.005},
                        Gyro{"poor: 0.02 deg/s, 0.3 %, 0.01 deg/s/rtHz", 0.02, 0.003, 0.01}}) {
    const Errors e = run(g, false, 24, 300);
    std::printf("%-46s %10.4f %12.4f %18.4f   (%d refused)\n", g.name, rms(e.pairwise), rms(e.ratio), rms(e.chained),
                e.refused);
    figures[std::string(g.name).substr(0, 4) + ".pairwise_deg"] = rms(e.pairwise);
    figures[std::string(g.name).substr(0, 4) + ".predicted_deg"] = rms(e.ratio);
  }
  const Errors one = run({"", 0.005, 0.0005, 0.005}, true, 24, 300);
  std::printf("turns about one axis only: %d of 300 refused as not observable\n", one.refused);
  figures["one_axis.refused"] = one.refused;
  return figures;
}

}  // namespace stillpoint::bench
