/// The online calibration on real recordings: what it improves on data that it did not learn from.
#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "bench/calibration_tables.h"
#include "calib_online/gyro_matrix.h"
#include "calib_online/online_calibrator.h"
#include "calib_online/rest_detector.h"
#include "core/units.h"
#include "io/recording.h"

namespace stillpoint::bench {
namespace {

using calib::Window;

std::vector<Window> windows_of(const io::Recording& r, const CalibrationSnapshot& used) {
  calib::RestDetector detector;
  std::vector<Window> out;
  for (std::size_t k = 0; k < r.size(); ++k)
    if (auto w = detector.push(r.sample(k), used)) out.push_back(*w);
  return out;
}

calib::OnlineCalibrator calibrated(const std::vector<Window>& windows) {
  calib::OnlineCalibrator c({}, CalibrationSnapshot{});
  for (const auto& w : windows) c.absorb(w);
  return c;
}
CalibrationSnapshot learn(const std::vector<Window>& windows) { return calibrated(windows).snapshot(); }

/// Which pose each window shows: windows of one direction together, numbered as they come.
std::vector<std::size_t> poses_of(const std::vector<Window>& windows) {
  std::vector<std::size_t> pose;
  std::vector<Vec3> directions;
  for (const auto& w : windows) {
    const Vec3 u = vec(w.acc_mps2).normalized();
    std::size_t k = 0;
    while (k < directions.size() && directions[k].dot(u) < 0.94) ++k;
    if (k == directions.size()) directions.push_back(u);
    pose.push_back(k);
  }
  return pose;
}

/// Leave one pose out.
void poses(const std::string& folder, Figures& figures) {
  const auto r = io::read_recording(folder + "/mpu6050_poses/example_data_calibration.csv");
  if (!r) return;
  const auto windows = windows_of(*r, {});
  const auto pose = poses_of(windows);
  const std::size_t count = pose.empty() ? 0 : *std::max_element(pose.begin(), pose.end()) + 1;
  std::vector<double> before, after;
  for (std::size_t held = 0; held < count; ++held) {
    std::vector<Window> rest;
    for (std::size_t k = 0; k < windows.size(); ++k)
      if (pose[k] != held) rest.push_back(windows[k]);
    const CalibrationSnapshot s = learn(rest);
    for (std::size_t k = 0; k < windows.size(); ++k) {
      if (pose[k] != held) continue;
      before.push_back(vec(windows[k].acc_mps2).norm() - kStandardGravity_mps2);
      after.push_back(s.acc.apply(windows[k].acc_mps2, windows[k].temp_degC).norm() - kStandardGravity_mps2);
    }
  }
  std::printf(
      "mpu6050_poses, %zu poses, each held out in turn: norm of the held-out pose off by %.3f m/s^2 rms before (%.2f "
      "to %.2f), %.3f after (%.3f to %.3f)\n",
      count, rms(before), quantile(before, 0) + kStandardGravity_mps2, quantile(before, 1) + kStandardGravity_mps2,
      rms(after), quantile(after, 0) + kStandardGravity_mps2, quantile(after, 1) + kStandardGravity_mps2);
  figures["poses.after_mps2"] = rms(after);
}

/// Integral of the calibrated rate between two rows, rad: a turn about one axis.
Vec3 turned(const io::Recording& r, const TriadCalibration& g, std::size_t from, std::size_t to) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t k = from + 1; k < to; ++k)
    sum +=
        0.5 * (r.t_s(k) - r.t_s(k - 1)) * (g.apply(array(r.gyr_radps[k]), 25) + g.apply(array(r.gyr_radps[k - 1]), 25));
  return sum;
}

/// What the gyro's matrix leaves open of a turn that the gyroscope reads as `raw`, rad: with the evidence of the turns
/// between windows, and with none.
struct TurnSd {
  double learnt = 0.0, prior = 0.0;
};
TurnSd turn_sd(const calib::OnlineCalibrator& c, const Vec3& raw) {
  const calib::GyroMatrixParams p;
  const Vec3 axis = raw.normalized();
  calib::Vec9 by_rows;  // d angle / d H
  for (int i = 0; i < 3; ++i) by_rows.segment<3>(3 * i) = axis[i] * raw;
  const auto sd_with = [&](const calib::GyroMatrixSums& sums) {
    return std::sqrt(by_rows.dot(solve(sums, Mat3::Identity(), p.scale_sd, p.cross_sd).covariance * by_rows));
  };
  return {sd_with(c.state().gyr_matrix.published), sd_with({})};
}

/// The first row at or after a time.
std::size_t row_at(const io::Recording& r, std::int64_t t_ns) {
  return static_cast<std::size_t>(std::lower_bound(r.t_ns.begin(), r.t_ns.end(), t_ns) - r.t_ns.begin());
}

void ferraris(const std::string& folder, Figures& figures) {
  const auto r = io::read_recording(folder + "/ferraris/ferraris_session.csv");
  if (!r) return;
  const auto windows = windows_of(*r, {});
  std::printf(
      "ferraris, each full turn read with the matrix learnt from all other turns and poses; what the matrix leaves "
      "open "
      "of it (1 sd), and left open before:\n");
  for (std::size_t k = 1; k < windows.size(); ++k) {
    const std::size_t from = row_at(*r, windows[k - 1].t_end_ns), to = row_at(*r, windows[k].t_start_ns);
    std::vector<Window> others = windows;
    others[k].rotation_valid = false;
    const auto c = calibrated(others);
    TriadCalibration plain = c.snapshot().gyr;
    plain.matrix = TriadCalibration{}.matrix;
    const Vec3 raw = turned(*r, plain, from, to);
    if (raw.norm() * kDegPerRad < 300) continue;
    const Vec3 up = vec(windows[k].acc_mps2).normalized();
    const TurnSd sd_rad = turn_sd(c, raw);
    const double after = turned(*r, c.snapshot().gyr, from, to).norm() * kDegPerRad;
    std::printf(
        "  turn ending at %5.1f s: %.2f before, %.2f after, sd %.2f (before %.2f); with its own turn too %.2f (gravity "
        "at its end %.2f %.2f %.2f)\n",
        in_seconds(windows[k].t_start_ns - r->t_ns[0]), raw.norm() * kDegPerRad, after, sd_rad.learnt * kDegPerRad,
        sd_rad.prior * kDegPerRad, turned(*r, learn(windows).gyr, from, to).norm() * kDegPerRad, up.x(), up.y(),
        up.z());
    double& worst = figures["ferraris.worst_sigma"];
    worst = std::max(worst, std::abs(after - 360.0) / (sd_rad.learnt * kDegPerRad));
  }
}

constexpr double kReferenceLag_s =
    0.0023;  // BROAD's optical reference lags the IMU by this (measured, docs/formats.md)

/// Stretches of `seconds` of motion with their reference rotation, the lag of the reference taken out.
std::vector<calib::GyroSegment> reference_segments(const io::Recording& r, const TriadCalibration& g, double seconds) {
  std::vector<calib::GyroSegment> out;
  const double dt = r.median_step_s();
  const auto step = static_cast<std::size_t>(seconds / dt);
  const auto row = [&r](std::size_t k) {
    const auto& q = r.ref_q_world_body[k];
    return Quat(q[0], q[1], q[2], q[3]);
  };
  const auto at = [&](std::size_t k) { return row(k).slerp(kReferenceLag_s / dt, row(k + 1)); };
  for (std::size_t k = 0; k + step + 2 < r.size(); k += step) {
    bool whole = r.ref_moving[k] > 0.5;
    for (const std::size_t i : {k, k + 1, k + step, k + step + 1}) whole = whole && r.ref_q_world_body[i].allFinite();
    for (std::size_t i = k; i <= k + step; ++i) whole = whole && r.gyr_radps[i].allFinite();
    if (!whole) continue;
    calib::GyroSegment s;
    s.dt_s = dt;
    for (std::size_t i = k; i < k + step; ++i) s.z.push_back(0.5 * (r.gyr_radps[i] + r.gyr_radps[i + 1]) - vec(g.bias));
    s.reference = (at(k).conjugate() * at(k + step)).normalized();
    out.push_back(s);
  }
  return out;
}

std::vector<double> rotation_errors_deg(const std::vector<calib::GyroSegment>& segments, const Mat3& H) {
  std::vector<double> e;
  for (const auto& s : segments)
    e.push_back(log_quat(calib::preintegrate(s, H).q.conjugate() * s.reference).norm() * kDegPerRad);
  return e;
}

/// Standard error of the difference of two rms over the same segments.
double error_of_change(const std::vector<double>& before, const std::vector<double>& after) {
  std::vector<double> d;
  for (std::size_t k = 0; k < before.size(); ++k) d.push_back(after[k] * after[k] - before[k] * before[k]);
  return sd(d) / std::sqrt(static_cast<double>(d.size())) / (rms(before) + rms(after));
}

/// Rotation over 10 s of motion with a matrix learnt elsewhere, trial by trial.
void rotation_of_trials(const std::string& folder, const Mat3& learnt, Figures& figures) {
  const std::vector<std::string> trials{
      "01_undisturbed_slow_rotation_A",    "03_undisturbed_slow_rotation_C",
      "06_undisturbed_fast_rotation_A",    "08_undisturbed_fast_rotation_with_breaks_A",
      "10_undisturbed_slow_translation_A", "15_undisturbed_fast_translation_A"};
  std::printf(
      "  rotation over 10 s of motion against the reference, deg rms, bias from each trial's own rest: factory -> from "
      "the reference of trial 04, the change with its standard error\n");
  for (const auto& name : trials) {
    const auto r = io::read_recording(folder + "/broad/" + name + ".csv");
    if (!r) continue;
    const auto segments = reference_segments(*r, learn(windows_of(*r, {})).gyr, 10.0);
    const auto before = rotation_errors_deg(segments, Mat3::Identity()), after = rotation_errors_deg(segments, learnt);
    std::printf("    %-46s %.3f -> %.3f   %+.3f +- %.3f\n", name.c_str(), rms(before), rms(after),
                rms(after) - rms(before), error_of_change(before, after));
    figures["broad." + name.substr(0, 2)] = rms(after) / rms(before);
  }
}

void broad(const std::string& folder, Figures& figures) {
  const auto learner = io::read_recording(folder + "/broad/04_undisturbed_slow_rotation_with_breaks_A.csv");
  if (!learner) return;
  const auto windows = windows_of(*learner, {});
  const CalibrationSnapshot s = learn(windows);
  const Mat3 by_gravity = mat(s.gyr.matrix);
  // What the reference is off at its two ends does not grow with the time between them: long segments.
  const auto learnt_on = reference_segments(*learner, s.gyr, 10.0);
  const Mat3 by_reference = calib::gyro_matrix_gauss_newton(learnt_on, Mat3::Identity(), 3);
  std::printf(
      "BROAD, gyro matrix learnt on trial 04. Left: online, from gravity in %zu windows of rest. They lie in one "
      "attitude, 100 s of\n"
      "turning apart: not observable, the prior stays. Right: Gauss-Newton on its reference rotations, %zu stretches "
      "of "
      "10 s.\n",
      windows.size(), learnt_on.size());
  for (int k = 0; k < 3; ++k)
    std::printf("    %8.4f %8.4f %8.4f      %8.4f %8.4f %8.4f\n", by_gravity(k, 0), by_gravity(k, 1), by_gravity(k, 2),
                by_reference(k, 0), by_reference(k, 1), by_reference(k, 2));
  rotation_of_trials(folder, by_reference, figures);
}

}  // namespace

Figures real_recordings(const std::string& folder) {
  std::printf("\n== Real recordings (%s) ==\n", folder.c_str());
  if (!std::filesystem::exists(folder)) {
    std::printf("SKIPPED: no such folder; give it with --recordings DIR\n");
    return {};
  }
  Figures figures;
  poses(folder, figures);
  ferraris(folder, figures);
  thermal_chamber(folder, figures);
  broad(folder, figures);
  return figures;
}

}  // namespace stillpoint::bench
