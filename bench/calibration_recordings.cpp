/// The online calibration on real recordings: what it improves on data that it did not learn from.
#include <cstdio>
#include <filesystem>

#include "bench/calibration_tables.h"
#include "calib_online/gyro_matrix.h"
#include "calib_online/online_calibrator.h"
#include "calib_online/rest_detector.h"
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

CalibrationSnapshot learn(const std::vector<Window>& windows) {
  calib::OnlineCalibrator c({}, CalibrationSnapshot{});
  for (int pass = 0; pass < 1; ++pass)
    for (const auto& w : windows) c.absorb(w);
  return c.snapshot();
}

/// Leave one pose out: windows of one direction together.
void poses(const std::string& folder) {
  const auto r = io::read_recording(folder + "/mpu6050_poses/example_data_calibration.csv");
  if (!r) return;
  const auto windows = windows_of(*r, {});
  std::vector<int> pose;
  std::vector<Vec3> directions;
  for (const auto& w : windows) {
    const Vec3 u = vec(w.acc_mps2).normalized();
    std::size_t k = 0;
    while (k < directions.size() && directions[k].dot(u) < 0.94) ++k;
    if (k == directions.size()) directions.push_back(u);
    pose.push_back(static_cast<int>(k));
  }
  std::vector<double> before, after;
  for (std::size_t held = 0; held < directions.size(); ++held) {
    std::vector<Window> rest;
    for (std::size_t k = 0; k < windows.size(); ++k)
      if (pose[k] != static_cast<int>(held)) rest.push_back(windows[k]);
    const CalibrationSnapshot s = learn(rest);
    for (std::size_t k = 0; k < windows.size(); ++k) {
      if (pose[k] != static_cast<int>(held)) continue;
      before.push_back(vec(windows[k].acc_mps2).norm() - kStandardGravity_mps2);
      after.push_back(s.acc.apply(windows[k].acc_mps2, windows[k].temp_degC).norm() - kStandardGravity_mps2);
    }
  }
  std::printf(
      "mpu6050_poses, %zu poses, each held out in turn: norm of the held-out pose off by %.3f m/s^2 rms before (%.2f "
      "to %.2f), %.3f after (%.3f to %.3f)\n",
      directions.size(), rms(before), quantile(before, 0) + kStandardGravity_mps2,
      quantile(before, 1) + kStandardGravity_mps2, rms(after), quantile(after, 0) + kStandardGravity_mps2,
      quantile(after, 1) + kStandardGravity_mps2);
}

/// Angle about the turn's own axis between two times.
double turned_deg(const io::Recording& r, const TriadCalibration& g, std::size_t from, std::size_t to) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t k = from + 1; k < to; ++k)
    sum +=
        0.5 * (r.t_s(k) - r.t_s(k - 1)) * (g.apply(array(r.gyr_radps[k]), 25) + g.apply(array(r.gyr_radps[k - 1]), 25));
  return sum.norm() * kDegPerRad;
}

void ferraris(const std::string& folder) {
  const auto r = io::read_recording(folder + "/ferraris/ferraris_session.csv");
  if (!r) return;
  const auto windows = windows_of(*r, {});
  std::printf("ferraris, each full turn read with the matrix learnt from all other turns and poses:\n");
  for (std::size_t k = 1; k < windows.size(); ++k) {
    std::size_t from = 0, to = 0;
    while (from < r->size() && r->t_ns[from] < windows[k - 1].t_end_ns) ++from;
    to = from;
    while (to < r->size() && r->t_ns[to] < windows[k].t_start_ns) ++to;
    std::vector<Window> others = windows;
    others[k].rotation_valid = false;
    const CalibrationSnapshot s = learn(others), all = learn(windows);
    TriadCalibration plain = s.gyr;
    plain.matrix = TriadCalibration{}.matrix;
    const double before = turned_deg(*r, plain, from, to);
    if (before < 300) continue;
    const Vec3 up = vec(windows[k].acc_mps2).normalized();
    std::printf(
        "  turn ending at %5.1f s: %.2f before, %.2f after; with its own turn too %.2f (gravity at its end %.2f %.2f "
        "%.2f)\n",
        1e-9 * static_cast<double>(windows[k].t_start_ns - r->t_ns[0]), before, turned_deg(*r, s.gyr, from, to),
        turned_deg(*r, all.gyr, from, to), up.x(), up.y(), up.z());
  }
}

void chamber(const std::string& folder) {
  const auto r = io::read_recording(folder + "/thermal_chamber/imu_thermal.csv");
  if (!r) return;
  std::size_t coldest = 0;
  for (std::size_t k = 0; k < r->size(); ++k)
    if (r->temp_degC[k] < r->temp_degC[coldest]) coldest = k;
  std::printf(
      "thermal_chamber, %.1f to %.1f to %.1f degC: fit one half, predict the other; rms x y z, before (the fitted "
      "half's mean) -> after\n",
      r->temp_degC.front(), r->temp_degC[coldest], r->temp_degC.back());
  for (const bool gyro : {true, false}) {
    const auto& y = gyro ? r->gyr_radps : r->acc_mps2;
    const double unit = gyro ? kRadPerDeg : 0.01;  // the prior's sizes: deg/s, or mg
    calib::GyrFilterParams p;
    p.bias_sd_radps = 100 * unit;
    p.bias_per_K_sd_radps = 0.1 * (gyro ? 1 : 30) * unit;
    p.bias_curvature_sd_radps = (gyro ? 0.5 : 30) * unit;
    p.wander_sd_radps = 0;
    p.mean_floor_radps = (gyro ? 0.05 : 1) * unit;
    for (const bool fit_falling : {true, false}) {
      calib::GyrFilter f(p);
      Vec3 sum = Vec3::Zero();
      int n = 0;
      const std::size_t stride = 20;  // block means: the rows' noise is white, the filter's windows are few
      const auto rows = [&](bool falling) {
        return falling ? std::pair<std::size_t, std::size_t>{0, coldest}
                       : std::pair<std::size_t, std::size_t>{coldest, r->size()};
      };
      const auto block = [&](std::size_t k, double& T) {
        Vec3 m = Vec3::Zero();
        T = 0;
        for (std::size_t i = k; i < k + stride; ++i)
          m += y[i] / static_cast<double>(stride), T += r->temp_degC[i] / static_cast<double>(stride);
        return m;
      };
      const auto [a, b] = rows(fit_falling);
      double T = 0;
      for (std::size_t k = a; k + stride <= b; k += stride) {
        const Vec3 m = block(k, T);
        const double tau = (T - 25) / calib::kTempScale_K;
        f.update(m, Mat3(std::pow(0.02 * unit, 2) * Mat3::Identity()), tau, tau * tau);
        sum += m;
        ++n;
      }
      std::vector<double> before[3], after[3];
      const auto [c, d] = rows(!fit_falling);
      for (std::size_t k = c; k + stride <= d; k += stride) {
        const Vec3 m = block(k, T);
        const double tau = (T - 25) / calib::kTempScale_K;
        for (int axis = 0; axis < 3; ++axis) {
          before[axis].push_back((m - sum / n)[axis] * (gyro ? kDegPerRad : 1));
          after[axis].push_back((m - f.at(tau, tau * tau))[axis] * (gyro ? kDegPerRad : 1));
        }
      }
      std::printf("  %s, fit on the %s half:", gyro ? "gyro, deg/s" : "acc, m/s^2", fit_falling ? "falling" : "rising");
      for (int axis = 0; axis < 3; ++axis) std::printf("   %.4f -> %.4f", rms(before[axis]), rms(after[axis]));
      std::printf("\n");
    }
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

double rotation_error_deg(const std::vector<calib::GyroSegment>& segments, const Mat3& H) {
  std::vector<double> e;
  for (const auto& s : segments)
    e.push_back(log_quat(calib::preintegrate(s, H).q.conjugate() * s.reference).norm() * kDegPerRad);
  return rms(e);
}

void broad(const std::string& folder) {
  const std::vector<std::string> trials{
      "01_undisturbed_slow_rotation_A",    "03_undisturbed_slow_rotation_C",
      "06_undisturbed_fast_rotation_A",    "08_undisturbed_fast_rotation_with_breaks_A",
      "10_undisturbed_slow_translation_A", "15_undisturbed_fast_translation_A"};
  const auto learner = io::read_recording(folder + "/broad/04_undisturbed_slow_rotation_with_breaks_A.csv");
  if (!learner) return;
  const auto windows = windows_of(*learner, {});
  const CalibrationSnapshot s = learn(windows);
  const Mat3 by_gravity = mat(s.gyr.matrix);
  const Mat3 by_reference =
      calib::gyro_matrix_gauss_newton(reference_segments(*learner, s.gyr, 2.0), Mat3::Identity(), 3);
  std::printf(
      "BROAD, gyro matrix learnt on trial 04. Left: online, from gravity in %zu windows of rest. They lie in one "
      "attitude, 100 s of\n"
      "turning apart: not observable, the prior stays. Right: Gauss-Newton on its reference rotations over 2 s.\n",
      windows.size());
  for (int k = 0; k < 3; ++k)
    std::printf("    %8.4f %8.4f %8.4f      %8.4f %8.4f %8.4f\n", by_gravity(k, 0), by_gravity(k, 1), by_gravity(k, 2),
                by_reference(k, 0), by_reference(k, 1), by_reference(k, 2));
  std::printf(
      "  rotation over 10 s of motion against the reference, deg rms, bias from each trial's own rest: none, online, "
      "from reference\n");
  for (const auto& name : trials) {
    const auto r = io::read_recording(folder + "/broad/" + name + ".csv");
    if (!r) continue;
    const auto segments = reference_segments(*r, learn(windows_of(*r, {})).gyr, 10.0);
    std::printf("    %-46s %.3f -> %.3f, %.3f\n", name.c_str(), rotation_error_deg(segments, Mat3::Identity()),
                rotation_error_deg(segments, by_gravity), rotation_error_deg(segments, by_reference));
  }
}

}  // namespace

Figures real_recordings(const std::string& folder) {
  std::printf("\n== Real recordings (%s) ==\n", folder.c_str());
  if (!std::filesystem::exists(folder)) {
    std::printf("SKIPPED: no such folder; give it with --recordings DIR\n");
    return {};
  }
  poses(folder);
  ferraris(folder);
  chamber(folder);
  broad(folder);
  return {};
}

}  // namespace stillpoint::bench
