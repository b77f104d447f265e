#include "apps/stillpoint/demo_score.h"

#include "pipeline/stages.h"

namespace stillpoint::app {

std::size_t row_at(const io::Recording& r, std::int64_t t_ns) {
  const auto it = std::lower_bound(r.t_ns.begin(), r.t_ns.end(), t_ns);
  return it != r.t_ns.end() && *it == t_ns ? static_cast<std::size_t>(it - r.t_ns.begin()) : r.size();
}

Quat truth_at(const io::Recording& r, std::size_t row) {
  const Eigen::Vector4d& q = r.ref_q_world_body[row];
  return Quat(q[0], q[1], q[2], q[3]);
}

bool is_scored(const io::Recording& r, std::size_t row) { return row < r.size() && 2 * row >= r.size(); }

AttitudeScore score_without_learning(const io::Recording& recording, const io::DaemonConfig& config) {
  pipeline::StagesParams params = io::stages_params(config);
  params.learn = false;
  params.attitude.gyr_bias_sd_radps = params.attitude.gyr_bias_walk_radps_rtHz = params.attitude.gyr_matrix_sd = 0.0;
  params.attitude.acc_bias_sd_mps2 = params.attitude.acc_bias_walk_mps2_rtHz = 0.0;
  calib::OnlineCalibrator calibrator(config.calibration.online, io::factory_calibration(config.sensor));
  pipeline::DirectLink link(calibrator);
  pipeline::Stages stages(params, calibrator.snapshot());
  pipeline::Processed out;
  AttitudeScore score;
  for (std::size_t row = 0; row < recording.size(); ++row) {
    if (stages.process(recording.sample(row), out, link) == pipeline::StageStatus::kDrop) continue;
    const auto& q = out.attitude.q_world_body;
    if (is_scored(recording, row)) score.add(Quat(q[0], q[1], q[2], q[3]), truth_at(recording, row));
  }
  return score;
}

}  // namespace stillpoint::app
