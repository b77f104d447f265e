#include "apps/stillpointd/slow_work.h"

#include <fmt/format.h>

#include "apps/stillpointd/log.h"
#include "core/units.h"
#include "io/calibration_state.h"

namespace stillpoint::app {
namespace {

std::string reason(const TriadCalibration& triad) {
  switch (triad.status) {
    case CalibrationStatus::kOk:
      return "";
    case CalibrationStatus::kFactory:
      return "nothing learnt yet: the configured values serve";
    case CalibrationStatus::kTooFewWindows:
      return fmt::format("only {} pieces of evidence so far", triad.windows);
    case CalibrationStatus::kNotObservable:
      return "too few directions were seen; turn the sensor onto its other sides";
    case CalibrationStatus::kNotPositiveDefinite:
      return "the readings at rest lie on no ellipsoid";
    case CalibrationStatus::kClipped:
      return "the readings sit at the sensor's limit";
    case CalibrationStatus::kStuck:
      return "the readings do not change";
    case CalibrationStatus::kReplaced:
      return "the readings contradict what was learnt: another sensor?";
  }
  return "";
}

CalibrationMessage to_message(const CalibrationSnapshot& snapshot, const std::string& sensor_id) {
  return {snapshot, sensor_id, {reason(snapshot.acc), reason(snapshot.gyr), reason(snapshot.mag)}};
}

/// The readings, bias and matrix not applied, in the axes of the body.
RawSample in_body_axes(const RawSample& sample, const pipeline::OutputFrame& frame) {
  CalibratedSample body;
  body.acc_mps2 = sample.acc_mps2;
  body.gyr_radps = sample.gyr_radps;
  body.mag_uT = sample.mag_uT;
  body = pipeline::in_frame(body, frame);
  RawSample out = sample;
  out.acc_mps2 = body.acc_mps2;
  out.gyr_radps = body.gyr_radps;
  out.mag_uT = body.mag_uT;
  return out;
}

Mat3 rotation_to_body(const pipeline::OutputFrame& frame) {
  const Mat3 R = frame.q_body_sensor.toRotationMatrix();
  return frame.world == pipeline::WorldFrame::kNed ? Mat3(Vec3(1, -1, -1).asDiagonal() * R) : R;
}

/// For `systemctl status`.
std::string one_line(const DiagnosticsMessage& d) {
  return fmt::format("{}, {:.1f} Hz, {}{}", name(d.status), d.rate_hz, d.message,
                     d.missing.empty() ? "" : "; " + d.missing);
}

}  // namespace

SlowWork::SlowWork(const SlowWorkParts& parts, const pipeline::Shared& shared)
    : parts_(parts),
      config_(parts.config),
      frame_(io::stages_params(parts.config).frame),
      shared_(shared),
      watch_(parts.source),
      start_ns_(monotonic_ns()),
      last_save_ns_(start_ns_),
      last_attitude_ns_(start_ns_),
      rate_(start_ns_) {
  parts_.wire.publish_calibration(to_message(parts_.calibrator.snapshot(), config_.sensor.id));
}

void SlowWork::on_sample(const pipeline::Outgoing& sample) {
  parts_.wire.publish_raw(sample.raw, sample.arrival_ns);
  if (!sample.published) return;
  noise_.add(sample.raw, sample.message.at_rest);
  if (config_.dds.ros2) {
    const CalibratedSample calibrated = pipeline::in_frame(sample.sample, frame_);
    const RawSample raw = in_body_axes(sample.raw, frame_);
    parts_.wire.publish_imu({sample.message, calibrated, raw, covariances_});
  }
  last_ = sample.message;
}

void SlowWork::on_calibration(const pipeline::Evidence& evidence, const CalibrationSnapshot& s) {
  parts_.wire.publish_calibration(to_message(s, config_.sensor.id));
  unsaved_ = true;
  log(
      fmt::format("calibration version={} t_s={:.2f} temp_degC={:.1f} gyr_bias_radps={:.5f},{:.5f},{:.5f} ({}) "
                  "acc_bias_mps2={:.4f},{:.4f},{:.4f} ({})",
                  s.version, in_seconds(evidence.t_end_ns()), evidence.temp_degC(), s.gyr.bias[0], s.gyr.bias[1],
                  s.gyr.bias[2], name(s.gyr.status), s.acc.bias[0], s.acc.bias[1], s.acc.bias[2], name(s.acc.status)));
}

bool SlowWork::stale(const pipeline::SensorReport& report, std::int64_t now_ns) const {
  if (report.last_arrival_ns == 0 || report.state != pipeline::SensorState::kRunning) return true;
  return too_old(report.last_arrival_ns, now_ns);
}

bool SlowWork::barren(std::int64_t now_ns) const { return attitudes_ > 0 && too_old(last_attitude_ns_, now_ns); }

bool SlowWork::too_old(std::int64_t t_ns, std::int64_t now_ns) const {
  return static_cast<double>(now_ns - t_ns) > 1e9 * parts_.live.stale_after_s;
}

void SlowWork::log_neighbours() {
  const io::Neighbours& now = outlet_.neighbours;
  if (now == told_neighbours_) return;
  const io::DdsParams dds = io::in_namespace(config_.dds);
  if (now.publishers > told_neighbours_.publishers)
    log(
        fmt::format("{} other program(s) publish '{}' in domain {}: a subscriber gets all of them mixed; give one "
                    "another dds.domain or dds.namespace",
                    now.publishers, dds.attitude_topic, dds.domain));
  if (now.of_other_type > told_neighbours_.of_other_type)
    log(
        fmt::format("{} other program(s) use the name '{}' in domain {} for another type: they and this daemon do not "
                    "hear each other",
                    now.of_other_type, dds.attitude_topic, dds.domain));
  if (now.refused > told_neighbours_.refused)
    log(fmt::format("a subscriber of '{}' gets nothing: it asks for {}", dds.attitude_topic, now.asked_for));
  if (now.unreachable > told_neighbours_.unreachable)
    log(fmt::format(
        "participant '{}' in domain {} cannot match: it names no address that dds.interface: {} reaches; let "
        "it use UDP on this machine, or set dds.interface to the address of its network",
        now.unreachable_name, dds.domain, dds.interface));
  told_neighbours_ = now;
}

/// A stranger may send as many as he likes: told when the number has doubled.
void SlowWork::log_refused_datagrams() {
  const io::RefusedDatagrams& now = outlet_.datagrams;
  const auto tell = [](std::uint64_t count, std::uint64_t& told, const char* what) {
    if (count < 2 * told || count == told) return;
    log(fmt::format("{} datagrams refused so far: {}", count, what));
    told = count;
  };
  tell(now.malformed, told_datagrams_.malformed, "malformed, and Fast DDS would read them");
  tell(now.off_host, told_datagrams_.off_host,
       "from another machine; a participant there cannot match while dds.interface is 127.0.0.1");
  tell(now.flooded, told_datagrams_.flooded, "announcements of more new participants than can be real");
}

void SlowWork::tell_news(const pipeline::SensorReport& report) {
  for (const auto& line : watch_.news(std::span(report.findings).first(report.found))) log(line);
  if (const std::string line = refused_rows_.news(report.guard); !line.empty()) log(line);
  const auto tell = [](std::uint64_t now, std::uint64_t& told, const char* what) {
    if (now > told) log(fmt::format("{} {} so far", now, what));
    told = now;
  };
  tell(report.ring_dropped, told_dropped_,
       "samples missing on the reliable topics: the calibration thread is too slow");
  tell(report.stages.answers_late, told_answers_late_, "calibrations later than calibration.answer_delay_s");
  tell(report.guard.clock_steps, told_clock_steps_, "steps of the sensor's clock, taken out of the pipeline's time");
  if (report.guard.late >= tell_readings_late_at_) {
    log(
        fmt::format("{} readings so far came later than sensor.limits.late_s, {} s, after the gyroscope's, and are not "
                    "used; raise it to the delay of the driver",
                    report.guard.late, config_.sensor.limits.late_s));
    tell_readings_late_at_ = 10 * report.guard.late;
  }
}

std::string SlowWork::why_stale(const pipeline::SensorReport& report, std::int64_t now_ns) const {
  if (report.state == pipeline::SensorState::kEnded) return "the source has ended";
  if (stale(report, now_ns))
    return fmt::format("no sample for {} s; nothing is repeated", parts_.live.stale_after_s.load());
  return barren(now_ns) ? "samples come, but no attitude can be made of them" : "";
}

void SlowWork::log_changes(const pipeline::SensorReport& report, std::int64_t now_ns) {
  const std::string why = why_stale(report, now_ns);
  if (why.empty() == told_stale_) log(why.empty() ? "samples arrive again" : "STALE: " + why);
  told_stale_ = !why.empty();
  tell_news(report);
  if (report.last_arrival_ns != 0)
    for (const auto& line : health_.news(report.health)) log(line);
  log_neighbours();
  log_refused_datagrams();
}

DiagnosticsMessage SlowWork::diagnostics(const pipeline::SensorReport& report, std::int64_t now_ns, bool is_stale) {
  DiagnosticsMessage d;
  d.uptime_s = in_seconds(now_ns - start_ns_);
  d.samples = report.guard.samples;
  d.rate_hz = rate_.look(d.samples, now_ns);
  if (report.usual_step_s > 0.0 && config_.source.speed > 0.0)
    d.expected_rate_hz = config_.source.speed / report.usual_step_s;
  d.gaps = report.guard.gaps;
  d.longest_gap_s = in_seconds(report.guard.longest_gap_ns);
  d.dropped = report.ring_dropped + report.stages.evidence_dropped;
  d.clipped = report.guard.clipped;
  d.refused = report.guard.unused();
  d.not_finite = report.guard.not_finite + report.guard.spikes;
  d.write_failures = report.write_failures;
  d.temp_degC = last_.temp_degC;
  const bool is_barren = barren(now_ns);
  d.status = is_stale || is_barren ? AttitudeStatus::kStale : last_.status;
  d.heading_reference = last_.heading_reference;
  d.health = report.health;
  d.sensor_id = config_.sensor.id;
  d.message = is_stale    ? "no sample from the source"
              : is_barren ? "samples come, but no attitude can be made of them"
                          : fmt::format("{} rest windows, calibration version {}", report.stages.windows,
                                        parts_.calibrator.snapshot().version);
  const io::RefusedDatagrams& datagrams = outlet_.datagrams;
  d.datagrams_malformed = datagrams.malformed;
  d.datagrams_off_host = datagrams.off_host;
  d.datagrams_flooded = datagrams.flooded;
  d.source = config_.source.description();
  d.missing = parts_.troubles.all();
  if (watch_.implausible() && d.status == AttitudeStatus::kOk) d.status = AttitudeStatus::kDegraded;
  if (refused_rows_.most() && d.status == AttitudeStatus::kOk) d.status = AttitudeStatus::kDegraded;
  for (const std::string& trouble : {watch_.trouble(), refused_rows_.trouble(), health_.silent()})
    if (!trouble.empty()) d.missing += (d.missing.empty() ? "" : "; ") + trouble;
  d.last_refusal = std::string(calib::name(report.last_refusal));
  d.latency_counts = shared_.latency.counts();
  d.latency_max_ns = shared_.latency.max_ns();
  return d;
}

void SlowWork::on_tick(const pipeline::SensorReport& report, std::int64_t now_ns) {
  const bool is_stale = stale(report, now_ns);
  if (const std::uint64_t now = report.published + report.write_failures; now != attitudes_) {
    attitudes_ = now;
    last_attitude_ns_ = now_ns;
  }
  outlet_ = parts_.wire.report();
  log_changes(report, now_ns);
  covariances_ = noise_.covariances(parts_.calibrator.snapshot(), rotation_to_body(frame_));
  const DiagnosticsMessage d = diagnostics(report, now_ns, is_stale);
  parts_.wire.publish_diagnostics(d);
  parts_.service.status(one_line(d));
  if (static_cast<double>(now_ns - last_save_ns_) > 1e9 * parts_.live.save_period_s) save();
}

void SlowWork::save() {
  last_save_ns_ = monotonic_ns();
  if (parts_.keeper == nullptr || !unsaved_) return;
  const std::string text = io::calibration_text(parts_.calibrator);
  parts_.keeper->keep(std::as_bytes(std::span(text)));
  unsaved_ = false;
}

}  // namespace stillpoint::app
