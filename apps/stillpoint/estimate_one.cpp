#include "apps/stillpoint/estimate_one.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "apps/stillpoint/attitude_file.h"
#include "apps/stillpoint/outcome.h"
#include "apps/stillpoint/plausible.h"
#include "core/so3.h"
#include "core/units.h"
#include "io/calibration_state.h"
#include "io/mounted_recording.h"
#include "io/plausibility_text.h"
#include "io/state_file.h"
#include "pipeline/smooth.h"

namespace stillpoint::app {
namespace {

/// What the daemon has kept of this sensor, as the daemon would start with it.
Result<void> restore(const std::string& path, calib::OnlineCalibrator& calibrator) {
  if (path.empty()) return {};
  const auto file = io::read_state_file(path);
  if (!file) return tl::unexpected(file.error());
  const auto taken = io::restore_calibration(file->text(), calibrator);
  if (!taken)
    return fail(ErrorKind::kBadData,
                path + ": " + taken.error().message + "; leave --state out, or run the daemon to learn anew");
  for (const std::string& remark : *taken) tell(fmt::format("{}: {}", path, remark));
  fmt::print(stderr, "{}: starts from what was kept of the sensor {}\n", path, file->sensor_id);
  return {};
}

/// Without an accelerometer nothing says where down is; without a gyroscope there is an attitude of a kind.
Result<void> has_what_it_needs(const io::Recording& recording, const std::string& path) {
  const auto sensors = io::sensor_times(recording);
  const auto read = [&sensors](std::string_view name) {
    return std::any_of(sensors.begin(), sensors.end(), [name](const auto& s) { return s.name == name; });
  };
  if (!read("acc"))
    return fail(ErrorKind::kBadData,
                path + ": no attitude: no reading of an accelerometer (acc_x_mps2 ...), which says where down is");
  if (!read("gyr"))
    tell("stillpoint: warning: " + path +
         ": no reading of a gyroscope (gyr_x_radps ...): turns are known by gravity and field alone");
  return {};
}

/// Writes as the samples come, or when all have been seen; the stages are those of the pass that was written.
class Writer {
 public:
  Writer(AttitudeFile& file, const io::Recording& recording, const pipeline::OutputFrame& frame, Estimated& out)
      : file_(file), recording_(recording), frame_(frame), out_(out), stride_(recording.size() / kMostMoments + 1) {}
  Result<void> add(const pipeline::Processed& processed) {
    if (out_.rows == 0) first_ns_ = processed.attitude.t_ns;
    const AttitudeStatus status = pipeline::to_message(processed).status;
    if (out_.rows++ % stride_ == 0) note_moment(processed.attitude, status);
    out_.degraded_rows += status == AttitudeStatus::kDegraded ? 1 : 0;
    out_.last = processed.attitude;
    out_.health = processed.health;
    out_.duration_s = in_seconds(processed.attitude.t_ns - first_ns_);
    return file_.add(processed);
  }
  void count(const pipeline::Stages& stages) {
    out_.guard = stages.guard().counts();
    out_.rest_windows = stages.counts().windows;
    out_.calibration = stages.live();
  }

 private:
  static constexpr std::size_t kMostMoments = 1000;

  void note_moment(const fusion::AttitudeEstimate& estimate, AttitudeStatus status) {
    CoursePoint moment{in_seconds(estimate.t_ns - first_ns_), estimate, status};
    const auto& times = recording_.t_ns;
    const auto row =
        static_cast<std::size_t>(std::lower_bound(times.begin(), times.end(), estimate.t_ns) - times.begin());
    if (row < recording_.ref_q_world_body.size() && recording_.ref_q_world_body[row].allFinite()) {
      const Eigen::Vector4d& q = recording_.ref_q_world_body[row];
      fusion::AttitudeEstimate truth;
      truth.q_world_body = {q[0], q[1], q[2], q[3]};
      moment.off_rad =
          log_quat(quat(pipeline::in_frame(truth, frame_).q_world_body) * quat(estimate.q_world_body).conjugate());
      if (estimate.heading == HeadingReference::kRelative)
        moment.off_rad->z() = std::numeric_limits<double>::quiet_NaN();
    }
    out_.course.push_back(moment);
  }

  AttitudeFile& file_;
  const io::Recording& recording_;
  pipeline::OutputFrame frame_;
  Estimated& out_;
  std::size_t stride_;
  std::int64_t first_ns_ = 0;
};

Result<void> causal(const io::Recording& recording, const pipeline::StagesParams& params,
                    calib::OnlineCalibrator& calibrator, Writer& writer) {
  pipeline::DirectLink link(calibrator);
  pipeline::Stages stages(params, calibrator.snapshot());
  pipeline::Processed out;
  for (std::size_t row = 0; row < recording.size(); ++row) {
    if (stages.process(recording.sample(row), out, link) == pipeline::StageStatus::kDrop) continue;
    if (auto written = writer.add(out); !written) return written;
  }
  writer.count(stages);
  return {};
}

Result<void> smoothed(const io::Recording& recording, const pipeline::StagesParams& params,
                      calib::OnlineCalibrator& calibrator, Writer& writer) {
  const auto sample = [&recording](std::size_t row) { return recording.sample(row); };
  const auto both = pipeline::smooth(recording.size(), sample, params, calibrator);
  for (const auto& row : both.rows)
    if (auto written = writer.add(row); !written) return written;
  writer.count(both.stages);
  return {};
}

nlohmann::json triad_json(const TriadCalibration& c) {
  return {{"bias", c.bias},          {"bias_per_K", c.bias_per_K}, {"temp_ref_degC", c.temp_ref_degC},
          {"matrix", c.matrix},      {"windows", c.windows},       {"norm_sd", c.norm_sd},
          {"status", name(c.status)}};
}

}  // namespace

Result<Estimated> estimate_one(const EstimateRequest& request, const io::DaemonConfig& config) {
  auto recording = io::read_recording(request.recording,
                                      request.skip_malformed ? io::OnMalformedRow::kCount : io::OnMalformedRow::kFail);
  if (!recording) return tl::unexpected(recording.error());
  if (config.source.mount) io::mount_sensors(*recording, *config.source.mount);
  for (const Finding& odd : warn_if_implausible(*recording, request.recording))
    if (is_too_slow(odd)) return fail(ErrorKind::kBadData, request.recording + ": no attitude: " + io::describe(odd));
  if (const auto enough = has_what_it_needs(*recording, request.recording); !enough)
    return tl::unexpected(enough.error());
  calib::OnlineCalibrator calibrator(config.calibration.online, io::factory_calibration(config.sensor));
  if (const auto known = restore(request.state, calibrator); !known) return tl::unexpected(known.error());
  auto file = AttitudeFile::create(request.output);
  if (!file) return tl::unexpected(file.error());
  Estimated out;
  out.samples = recording->size();
  out.issues = recording->issues;
  const pipeline::StagesParams params = io::stages_params(config);
  Writer writer(*file, *recording, params.frame, out);
  const auto done = (request.smooth ? smoothed : causal)(*recording, params, calibrator, writer);
  if (!done) return tl::unexpected(done.error());
  if (auto written = file->finish(); !written) return tl::unexpected(written.error());
  return out;
}

nlohmann::json to_json(const Estimated& e) {
  return {{"schema", "stillpoint.estimate/1"},
          {"rows", e.rows},
          {"samples", e.samples},
          {"dropped_rows", e.issues.dropped_rows()},
          {"refused", e.guard.refused},
          {"gaps", e.guard.gaps},
          {"clipped", e.guard.clipped},
          {"not_finite", e.guard.not_finite + e.issues.not_finite.count},
          {"spikes", e.guard.spikes},
          {"rest_windows", e.rest_windows},
          {"calibration",
           {{"version", e.calibration.version},
            {"acc", triad_json(e.calibration.acc)},
            {"gyr", triad_json(e.calibration.gyr)},
            {"mag", triad_json(e.calibration.mag)}}}};
}

std::string to_text(const Estimated& e, const EstimateRequest& request) {
  std::string text;
  const auto to = std::back_inserter(text);
  for (const auto& line : io::describe(e.issues)) fmt::format_to(to, "{}: {}\n", request.recording, line);
  fmt::format_to(to, "{}: {} rows{}\n", request.output, e.rows, request.smooth ? ", smoothed" : "");
  fmt::format_to(to, "rest windows {}, calibration version {}; gaps {}, refused {}\n", e.rest_windows,
                 e.calibration.version, e.guard.gaps, e.guard.refused);
  const auto& b = e.calibration.gyr.bias;
  fmt::format_to(to, "gyroscope bias {:.4f} {:.4f} {:.4f} deg/s, {}\n", b[0] * kDegPerRad, b[1] * kDegPerRad,
                 b[2] * kDegPerRad, name(e.calibration.gyr.status));
  const auto& a = e.calibration.acc.bias;
  fmt::format_to(to, "accelerometer bias {:.4f} {:.4f} {:.4f} m/s^2, {}\n", a[0], a[1], a[2],
                 name(e.calibration.acc.status));
  fmt::format_to(to, "standard deviation at the end: roll {:.3f}, pitch {:.3f}, yaw {:.3f} deg\n",
                 e.last.sigma_roll_rad * kDegPerRad, e.last.sigma_pitch_rad * kDegPerRad,
                 e.last.sigma_yaw_rad * kDegPerRad);
  return text;
}

}  // namespace stillpoint::app
