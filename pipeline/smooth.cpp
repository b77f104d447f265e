#include "pipeline/smooth.h"

#include <cmath>
#include <utility>

#include "core/so3.h"

namespace stillpoint::pipeline {
namespace {

constexpr double kNoHeading_rad2 = 1e6;
constexpr double kMuchLessSure = 4.0;  ///< in the mean variance: deviations twice as large

/// As a clock that runs backward from `last_ns` would see it: forces and fields stay, turns are the other way round.
/// A rate holds from the sample before to its own; so the one that led to the row seen `before`, which is the later.
CalibratedSample reversed(const CalibratedSample& sample, const CalibratedSample& before, std::int64_t last_ns) {
  CalibratedSample r = sample;
  r.t_ns = last_ns - sample.t_ns;
  r.gyr_radps = before.gyr_radps;
  vec(r.gyr_radps) *= -1.0;
  const auto of_before = [](std::uint8_t own, std::uint8_t later) {
    return static_cast<std::uint8_t>((own & ~kGyr) | (later & kGyr));
  };
  r.has = of_before(r.has, before.has);
  r.absent = of_before(r.absent, before.absent);
  r.clipped = of_before(r.clipped, before.clipped);
  return r;
}

Smoothed forward_pass(std::size_t rows, const SampleAt& sample, const StagesParams& params,
                      calib::OnlineCalibrator& calibrator) {
  Smoothed out{{}, Stages(params, calibrator.snapshot())};
  DirectLink link(calibrator);
  Processed processed;
  for (std::size_t row = 0; row < rows; ++row)
    if (out.stages.process(sample(row), processed, link) != StageStatus::kDrop) out.rows.push_back(processed);
  return out;
}

double stated_rad2(const Smoothed& pass) {
  double sum = 0.0;
  for (const Processed& p : pass.rows) sum += mat(p.attitude.covariance_world_rad2).trace();
  return sum;
}

}  // namespace

fusion::AttitudeEstimate fused(const fusion::AttitudeEstimate& forward,
                               const fusion::AttitudeEstimate& backward) noexcept {
  fusion::AttitudeEstimate out = forward;
  const Mat3 pulled = mat(forward.unexplained_rad2), pulled_back = mat(backward.unexplained_rad2);
  const Mat3 P = mat(forward.covariance_world_rad2) - pulled;
  Mat3 Q = mat(backward.covariance_world_rad2) - pulled_back;
  Quat turn = quat(backward.q_world_body) * quat(forward.q_world_body).conjugate();
  if (backward.heading == HeadingReference::kRelative) {
    turn = Quat(Eigen::AngleAxisd(-2.0 * std::atan2(turn.z(), turn.w()), Vec3::UnitZ())) * turn;
    Q(2, 2) += kNoHeading_rad2;
  }
  if (Q(2, 2) < P(2, 2)) out.heading = backward.heading;
  const Vec3 apart = log_quat(turn);
  const Mat3 gain = P * (P + Q).inverse();
  out.q_world_body = array(exp_quat(gain * apart) * quat(forward.q_world_body));
  // Both stand on one calibration, one field and one end of the recording, so they are no two witnesses: covariance
  // intersection with equal weights, and neither alone where that is less.
  Mat3 told = 2.0 * (P - gain * P);
  for (const Mat3& alone : {P, Q})
    if (alone.trace() < told.trace()) told = alone;
  const Mat3 kept = Mat3::Identity() - gain;
  out.unexplained_rad2 = array(Mat3(kept * pulled * kept.transpose() + gain * pulled_back * gain.transpose()));
  out.covariance_world_rad2 = array(Mat3(told + mat(out.unexplained_rad2)));
  fusion::set_sigmas(out);
  return out;
}

Smoothed smooth(std::size_t rows, const SampleAt& sample, const StagesParams& params,
                calib::OnlineCalibrator& calibrator) {
  StagesParams offline = params;
  offline.attitude.prediction_s = 0.0;
  Smoothed out = forward_pass(rows, sample, offline, calibrator);
  if (params.learn) {
    // What is known at the end mostly serves the beginning better. Where it does not (a magnet that came half-way is
    // part of the last calibration) the pass says so itself.
    offline.learn = false;
    Smoothed known = forward_pass(rows, sample, offline, calibrator);
    if (stated_rad2(known) < kMuchLessSure * stated_rad2(out)) out = std::move(known);
  }
  if (out.rows.empty()) return out;
  fusion::AttitudeFilter filter = out.stages.filter();
  filter.turn_back();
  const std::int64_t last_ns = out.rows.back().sample.t_ns;
  CalibratedSample before = out.rows.back().sample;
  for (auto p = out.rows.rbegin(); p != out.rows.rend(); ++p) {
    const CalibratedSample here = believed(p->sample, p->health);
    const auto backward = filter.step(reversed(here, before, last_ns), p->attitude.at_rest);
    const fusion::AttitudeEstimate forward = p->attitude;
    p->attitude = fused(forward, in_frame(backward, params.frame));
    if (HealthMonitor::unfounded(p->health)) {  // it stands on the same sensors
      p->attitude.covariance_world_rad2 = forward.covariance_world_rad2;
      fusion::set_sigmas(p->attitude);
    }
    before = here;
  }
  return out;
}

}  // namespace stillpoint::pipeline
