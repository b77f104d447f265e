#include "apps/stillpointd/slow_work.h"

#include <fmt/format.h>

#include "apps/stillpointd/log.h"

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

}  // namespace

SlowWork::SlowWork(const io::DaemonConfig& config, io::DdsPublisher& publisher, calib::OnlineCalibrator& calibrator,
                   const io::StateStore* store, const pipeline::Shared& shared)
    : config_(config),
      frame_(io::stages_params(config).frame),
      publisher_(publisher),
      calibrator_(calibrator),
      store_(store),
      shared_(shared),
      start_ns_(monotonic_ns()),
      last_tick_ns_(start_ns_),
      last_save_ns_(start_ns_) {
  publisher_.publish_calibration(to_message(calibrator_.snapshot(), config_.sensor.id));
}

void SlowWork::on_sample(const pipeline::Outgoing& sample) {
  publisher_.publish_raw(sample.raw, sample.arrival_ns);
  if (!sample.published) return;
  publisher_.publish_imu(sample.message, pipeline::in_frame(sample.sample, frame_));
  last_ = sample.message;
}

void SlowWork::on_calibration(const pipeline::Evidence& evidence, const CalibrationSnapshot& s) {
  publisher_.publish_calibration(to_message(s, config_.sensor.id));
  unsaved_ = true;
  log(fmt::format(
      "calibration version={} t_s={:.2f} temp_degC={:.1f} gyr_bias_radps={:.5f},{:.5f},{:.5f} ({}) "
      "acc_bias_mps2={:.4f},{:.4f},{:.4f} ({})",
      s.version, 1e-9 * static_cast<double>(evidence.t_end_ns()), evidence.temp_degC(), s.gyr.bias[0], s.gyr.bias[1],
      s.gyr.bias[2], name(s.gyr.status), s.acc.bias[0], s.acc.bias[1], s.acc.bias[2], name(s.acc.status)));
}

bool SlowWork::stale(const pipeline::SensorReport& report, std::int64_t now_ns) const {
  if (report.last_arrival_ns == 0 || report.state != pipeline::SensorState::kRunning) return true;
  return static_cast<double>(now_ns - report.last_arrival_ns) > 1e9 * config_.stale_after_s;
}

void SlowWork::log_neighbours() {
  const io::Neighbours now = publisher_.neighbours();
  if (now == told_neighbours_) return;
  const auto& dds = config_.dds;
  if (now.publishers > told_neighbours_.publishers)
    log(
        fmt::format("{} other program(s) publish '{}' in domain {}: a subscriber gets all of them mixed; give one "
                    "another dds.domain or dds.attitude_topic",
                    now.publishers, dds.attitude_topic, dds.domain));
  if (now.of_other_type > told_neighbours_.of_other_type)
    log(
        fmt::format("{} other program(s) use the name '{}' in domain {} for another type: they and this daemon do not "
                    "hear each other",
                    now.of_other_type, dds.attitude_topic, dds.domain));
  if (now.refused > told_neighbours_.refused)
    log(fmt::format("a subscriber of '{}' gets nothing: it asks for {}", dds.attitude_topic, now.asked_for));
  told_neighbours_ = now;
}

void SlowWork::log_changes(const pipeline::SensorReport& report, bool is_stale) {
  if (is_stale != told_stale_ && !is_stale) log("samples arrive again");
  if (is_stale != told_stale_ && is_stale)
    log(report.state == pipeline::SensorState::kEnded
            ? "STALE: the source has ended"
            : fmt::format("STALE: no sample for {} s; nothing is repeated", config_.stale_after_s));
  told_stale_ = is_stale;
  log_neighbours();
  const auto tell = [](std::uint64_t now, std::uint64_t& told, const char* what) {
    if (now > told) log(fmt::format("{} {} so far", now, what));
    told = now;
  };
  tell(report.ring_dropped, told_dropped_,
       "samples missing on the reliable topics: the calibration thread is too slow");
  tell(report.stages.answers_late, told_late_, "calibrations later than calibration.answer_delay_s");
  tell(report.guard.clock_steps, told_clock_steps_, "steps of the sensor's clock, taken out of the pipeline's time");
}

DiagnosticsMessage SlowWork::diagnostics(const pipeline::SensorReport& report, std::int64_t now_ns, bool is_stale) {
  DiagnosticsMessage d;
  d.uptime_s = 1e-9 * static_cast<double>(now_ns - start_ns_);
  d.samples = report.guard.samples;
  if (now_ns > last_tick_ns_)
    d.rate_hz = static_cast<double>(d.samples - last_samples_) / (1e-9 * static_cast<double>(now_ns - last_tick_ns_));
  if (report.usual_step_s > 0.0 && config_.source.speed > 0.0)
    d.expected_rate_hz = config_.source.speed / report.usual_step_s;
  d.gaps = report.guard.gaps;
  d.longest_gap_s = 1e-9 * static_cast<double>(report.guard.longest_gap_ns);
  d.dropped = report.ring_dropped + report.stages.evidence_dropped;
  d.clipped = report.guard.clipped;
  d.refused = report.guard.refused + report.stages.gate_refused;
  d.write_failures = report.write_failures;
  d.temp_degC = last_.temp_degC;
  d.status = is_stale ? AttitudeStatus::kStale : last_.status;
  d.heading_reference = last_.heading_reference;
  d.sensor_id = config_.sensor.id;
  d.message = is_stale ? "no sample from the source"
                       : fmt::format("{} rest windows, calibration version {}", report.stages.windows,
                                     calibrator_.snapshot().version);
  d.last_refusal = std::string(calib::name(report.last_refusal));
  d.latency_counts = shared_.latency.counts();
  d.latency_max_ns = shared_.latency.max_ns();
  return d;
}

void SlowWork::on_tick(const pipeline::SensorReport& report, std::int64_t now_ns) {
  const bool is_stale = stale(report, now_ns);
  log_changes(report, is_stale);
  publisher_.publish_diagnostics(diagnostics(report, now_ns, is_stale));
  last_samples_ = report.guard.samples;
  last_tick_ns_ = now_ns;
  if (static_cast<double>(now_ns - last_save_ns_) > 1e9 * config_.state.save_period_s) save();
}

void SlowWork::save() {
  last_save_ns_ = monotonic_ns();
  if (store_ == nullptr || !unsaved_) return;
  const calib::OnlineCalibrator::State state = calibrator_.state();
  const auto saved = store_->save(std::as_bytes(std::span(&state, 1)));
  if (!saved && !told_save_failure_) log(saved.error().message);
  told_save_failure_ = !saved;
  unsaved_ = !saved;
}

}  // namespace stillpoint::app
