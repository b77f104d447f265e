/// Angle between triads from the gyroscope's own rotations, chained and pairwise.
#include <Eigen/Dense>
#include <cstdio>

#include "bench/calibration_tables.h"
#include "calib_online/offline/alignment.h"
#include "calib_online/offline/two_step.h"

namespace stillpoint::bench {
namespace {

struct Gyro {
  const char* name;
  double bias_dps, scale, noise_dps_rtHz;
};

constexpr double kTurn_s = 3.0;
constexpr double kDirectionSd_rad = 0.0005;

/// A gyroscope and a triad whose axes stand a degree apart, as drawn for one run.
struct Device {
  Mat3 R_gyr_triad;  // triad axes into gyro axes
  Vec3 bias_radps;
  Mat3 scale = Mat3::Identity();
  Device(const Gyro& gyro, Random& random)
      : R_gyr_triad(exp_so3(random.normal3(1.0 * kRadPerDeg))),
        bias_radps(gyro.bias_dps * kRadPerDeg * random.direction()) {
    for (int i = 0; i < 3; ++i) scale(i, i) += random.normal(gyro.scale);
  }
};

/// The evidence of a run: rests with a turn before each but the first.
struct Evidence {
  calib::PairwiseSums pairs;
  calib::TwoStepSums chain;  ///< each rest against the first, as Zhang has it
};
Evidence observe(const Gyro& gyro, const Device& device, bool one_axis, int windows, Random& random) {
  Evidence out;
  Quat q_world_body = random.rotation();
  Mat3 R_now_first = Mat3::Identity();
  Vec3 before = Vec3::Zero();
  for (int w = 0; w < windows; ++w) {
    Mat3 R_measured = Mat3::Identity();  // previous from this
    double angle = 0.0;
    if (w > 0) {
      const Vec3 turn = (one_axis ? Vec3(0.6, 0, 0.8) : random.direction()) * random.uniform(0.7, 2.2);
      angle = turn.norm();
      q_world_body = q_world_body * exp_quat(turn);
      R_measured = exp_so3(device.scale * turn + kTurn_s * device.bias_radps +
                           random.normal3(gyro.noise_dps_rtHz * kRadPerDeg * std::sqrt(kTurn_s)));
    }
    const Vec3 up =
        device.R_gyr_triad.transpose() * (q_world_body.conjugate() * Vec3::UnitZ()) + random.normal3(kDirectionSd_rad);
    R_now_first = R_measured.transpose() * R_now_first;
    out.chain.add(up, R_now_first);
    if (w > 0) {
      const double sd =
          std::sqrt(std::pow(kTurn_s * gyro.bias_dps * kRadPerDeg, 2) / 3 + std::pow(gyro.scale * angle, 2) / 3 +
                    std::pow(gyro.noise_dps_rtHz * kRadPerDeg, 2) * kTurn_s);
      out.pairs.add(before, up, R_measured, kDirectionSd_rad * kDirectionSd_rad, Mat3(sd * sd * Mat3::Identity()));
    }
    before = up;
  }
  return out;
}

struct Errors {
  std::vector<double> pairwise, chained, predicted_sd;
  int refused = 0;
};

Errors run(const Gyro& gyro, bool one_axis, int windows, int runs) {
  Errors out;
  Random random(77);
  for (int k = 0; k < runs; ++k) {
    const Device device(gyro, random);
    const Evidence seen = observe(gyro, device, one_axis, windows, random);
    const auto error_deg = [&device](const Mat3& R_gyr_triad) {
      return log_so3(Mat3(R_gyr_triad * device.R_gyr_triad.transpose())).norm() * kDegPerRad;
    };
    const auto a = calib::align(seen.pairs, Mat3::Identity());
    if (a.status != calib::FitStatus::kOk) {
      ++out.refused;
      continue;
    }
    out.pairwise.push_back(error_deg(a.R_gyr_triad));
    out.predicted_sd.push_back(std::sqrt(a.covariance.trace()) * kDegPerRad);
    const auto absolute = calib::two_step_closed(seen.chain, 1.0, Mat3::Identity());
    const Eigen::JacobiSVD<Mat3> svd(absolute.H, Eigen::ComputeFullU | Eigen::ComputeFullV);
    out.chained.push_back(error_deg(svd.matrixU() * svd.matrixV().transpose()));
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
    std::printf("%-46s %10.4f %12.4f %18.4f   (%d refused)\n", g.name, rms(e.pairwise), rms(e.predicted_sd),
                rms(e.chained), e.refused);
    figures[std::string(g.name).substr(0, 4) + ".pairwise_deg"] = rms(e.pairwise);
    figures[std::string(g.name).substr(0, 4) + ".predicted_deg"] = rms(e.predicted_sd);
  }
  const Errors one = run({"", 0.005, 0.0005, 0.005}, true, 24, 300);
  std::printf("turns about one axis only: %d of 300 refused as not observable\n", one.refused);
  figures["one_axis.refused"] = one.refused;
  return figures;
}

}  // namespace stillpoint::bench
