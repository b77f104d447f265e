/// `stillpoint calibrate --recording`: the daemon's rest detection and calibration over a file, with what they could
/// not see.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <span>
#include <vector>

#include "apps/stillpoint/calibrate.h"
#include "apps/stillpoint/calibrate_output.h"
#include "apps/stillpoint/calibrate_page.h"
#include "apps/stillpoint/calibrate_report.h"
#include "apps/stillpoint/json_text.h"
#include "apps/stillpoint/known_turns.h"
#include "apps/stillpoint/outcome.h"
#include "apps/stillpoint/plausible.h"
#include "apps/stillpoint/progress.h"
#include "calib_online/field_turns.h"
#include "calib_online/offline/field_again.h"
#include "calib_online/online_calibrator.h"
#include "calib_online/rest_detector.h"
#include "core/median.h"
#include "io/calibration_state.h"
#include "io/config.h"
#include "io/mounted_recording.h"
#include "io/quote.h"
#include "io/recording.h"
#include "io/state_file.h"
#include "io/text_file.h"
#include "pipeline/assemble_stage.h"
#include "pipeline/guard_stage.h"

namespace stillpoint::app {
namespace {

const std::string kUnnamed = "unnamed";  // the state of a sensor that no recording named

/// What was learnt before, if the file is there; the daemon's state files are of the same form. `sensor_id` is the
/// recording's, empty when it names none, and is filled in from the file then.
Result<void> read_state(const std::string& path, std::string& sensor_id, calib::OnlineCalibrator& calibrator) {
  const auto refused = [&path](const std::string& why) {
    return fail(ErrorKind::kBadData, path + ": " + why + "; set it aside and run again");
  };
  const auto file = io::read_state_file(path);
  if (!file && file.error().kind == ErrorKind::kNoInput) return {};
  if (!file) return refused(file.error().message);
  if (!sensor_id.empty() && file->sensor_id != sensor_id && file->sensor_id != kUnnamed)
    return refused(
        fmt::format("it is of the sensor {}, the recording of {}", io::quote(file->sensor_id), io::quote(sensor_id)));
  const auto taken = io::restore_calibration(file->text(), calibrator);
  if (!taken) return refused(taken.error().message);
  for (const std::string& remark : *taken) tell(fmt::format("{}: {}", path, remark));
  if (sensor_id.empty()) sensor_id = file->sensor_id;
  return {};
}

Result<void> write_state(const std::string& path, const std::string& sensor_id,
                         const calib::OnlineCalibrator& calibrator) {
  const std::string text = io::calibration_text(calibrator);
  const auto bytes = std::as_bytes(std::span(text));
  return io::write_state_file(path, {sensor_id.empty() ? kUnnamed : sensor_id, {bytes.begin(), bytes.end()}});
}

/// A sensor that begins to be stuck, clipped or another one.
void note_faults(const CalibrationSnapshot& now, double t_s, CalibrationRun& run) {
  const std::array<const TriadCalibration*, 3> triads{&now.acc, &now.gyr, &now.mag};
  constexpr std::array<const char*, 3> kSensors{"accelerometer", "gyroscope", "magnetometer"};
  for (std::size_t k = 0; k < 3; ++k) {
    const CalibrationStatus status = triads[k]->status;
    const bool fault = status == CalibrationStatus::kStuck || status == CalibrationStatus::kClipped ||
                       status == CalibrationStatus::kReplaced;
    if (fault && status != run.status[k]) run.faults.push_back({t_s, kSensors[k], status});
    run.status[k] = status;
  }
}

double middle_norm(const std::vector<Vec3>& readings) {
  std::vector<double> norms;
  for (const Vec3& y : readings)
    if (y.allFinite()) norms.push_back(y.norm());
  return median(std::move(norms));
}

/// take(row, sample) for what the daemon's first stages make of the rows; gyr(row): what is known of the gyroscope by
/// then.
template <class Gyr, class Take>
void each_sample(const io::Recording& recording, const char* doing, const Gyr& gyr, const Take& take) {
  const pipeline::GuardParams usual;
  pipeline::GuardStage guard(usual);
  pipeline::AssembleStage assemble(usual.late_s, gyr(0));  // sensors may have rows of their own
  Progress progress(doing);
  for (std::size_t row = 0; row < recording.size(); ++row) {
    if (row % 4096 == 0) progress.at(static_cast<double>(row) / static_cast<double>(recording.size()));
    pipeline::GuardedSample as_read, joined;
    if (guard.process(recording.sample(row), as_read) == pipeline::StageStatus::kDrop) continue;
    assemble.use(gyr(row));
    if (assemble.process(as_read, joined) == pipeline::StageStatus::kDrop) continue;
    take(row, joined);
  }
}

/// The turns of the field by the matrix of the gyroscope that all of the recording has told, and the bias of the rest
/// after each: they are known when the recording is over.
std::vector<calib::FieldTurn> field_turns(const io::Recording& recording, const CalibrationRun& run,
                                          CalibrationSnapshot known) {
  std::vector<calib::FieldTurn> out;
  calib::FieldTurnFinder turns;
  auto next = run.course.begin();
  const auto gyr = [&](std::size_t row) -> const TriadCalibration& {
    const double t_s = recording.t_s(row) - recording.t_s(0);
    while (next != run.course.end() && (next->t_s < t_s || next->known.gyr.windows == 0)) ++next;
    known.gyr.bias = next == run.course.end() ? run.learnt.gyr.bias : next->known.gyr.bias;
    return known.gyr;
  };
  each_sample(recording, "calibrating the magnetometer", gyr, [&](std::size_t, const pipeline::GuardedSample& joined) {
    if (auto turn = turns.push(joined.sample, joined.clipped, known, joined.mag_turn_rad)) out.push_back(*turn);
  });
  return out;
}

/// Keeps what the daemon's order taught where it is as sure. Twice: iron that is taken out of the readings is not
/// shortened in the means of a turning body.
void learn_field_again(const io::Recording& recording, const calib::MagLearner& at_first,
                       calib::OnlineCalibrator& calibrator, CalibrationRun& run) {
  CalibrationSnapshot known = run.learnt;
  calib::MagLearner again = at_first;
  for (int round = 0; round < 2; ++round) {
    again = calib::learn_field(at_first, field_turns(recording, run, known), run.state.gyr_matrix_sd,
                               run.learnt.gyr.norm_sd);
    known.mag = again.so_far().value_or(known.mag);
  }
  TriadCalibration learnt;
  again.publish(learnt);
  const TriadCalibration& before = run.learnt.mag;
  const bool was_known = before.status == CalibrationStatus::kOk;
  if (learnt.status != CalibrationStatus::kOk || (was_known && before.norm_sd <= learnt.norm_sd)) return;
  calibrator.take_field(again);
  run.learnt = calibrator.snapshot();
  run.state = calibrator.state();
  run.course.push_back({run.duration_s, run.learnt});
}

CalibrationRun calibrate(const io::Recording& recording, calib::OnlineCalibrator& calibrator,
                         calib::RestDetectorParams params) {
  CalibrationRun run;
  run.gravity_mps2 = params.gravity_mps2 = calibrator.params().gravity_mps2;
  run.factory = calibrator.factory();
  calib::RestDetector detector(params);
  calib::FieldTurnFinder turns;
  std::size_t last_row = 0;  // that gave a sample
  const auto gyr = [&](std::size_t) -> const TriadCalibration& { return calibrator.snapshot().gyr; };
  each_sample(recording, "calibrating", gyr, [&](std::size_t row, const pipeline::GuardedSample& joined) {
    const auto window = detector.push(joined.sample, calibrator.snapshot());
    const auto note_if = [&](bool changed) {
      if (changed) run.course.push_back({recording.t_s(row) - recording.t_s(0), calibrator.snapshot()});
    };
    if (const auto turn = turns.push(joined.sample, joined.clipped, calibrator.snapshot(), joined.mag_turn_rad))
      note_if(calibrator.absorb(*turn));
    run.refused_s[std::string(calib::name(detector.last_refusal()))] += recording.t_s(row) - recording.t_s(last_row);
    last_row = row;
    if (!window) return;
    if (window->has != 0) run.windows.push_back(*window);
    note_if(calibrator.absorb(*window));
    note_faults(calibrator.snapshot(), recording.t_s(row), run);
  });
  run.middle_norm_mps2 = middle_norm(recording.acc_mps2);
  run.learnt = calibrator.snapshot();
  run.gyr_matrix = calibrator.gyr_matrix();
  run.state = calibrator.state();
  run.has_mag = !recording.mag_uT.empty();
  run.begin_ns = recording.t_ns.front();
  run.duration_s = recording.t_s(recording.size() - 1) - recording.t_s(0);
  return run;
}

/// Of a bias, (rad/s)^2, in this time.
double drift_var(const calib::GyrFilterParams& p, double dt_s) {
  return p.bias_walk_radps_rts * p.bias_walk_radps_rts * dt_s +
         2.0 * p.wander_sd_radps * p.wander_sd_radps * (1.0 - std::exp(-dt_s / p.wander_s));
}

/// The gyroscope as it was known best after a turn: the rest after it is near, later ones in other attitudes show what
/// a turn about its vertical might hide.
TriadCalibration gyr_after(double t_s, const CalibrationRun& run, const calib::GyrFilterParams& params) {
  TriadCalibration best = run.learnt.gyr;
  if (!(best.bias_covariance[0] > 0.0))
    best.bias_covariance = array(Mat3(params.bias_sd_radps * params.bias_sd_radps * Mat3::Identity()));
  double least = std::numeric_limits<double>::infinity();
  for (const CalibrationMoment& m : run.course) {
    if (m.t_s < t_s || m.known.gyr.windows == 0) continue;
    TriadCalibration gyr = m.known.gyr;
    mat(gyr.bias_covariance) += drift_var(params, m.t_s - t_s) * Mat3::Identity();
    if (mat(gyr.bias_covariance).trace() < least) best = gyr, least = mat(gyr.bias_covariance).trace();
  }
  return best;
}

/// Known turns need the bias, which the rests of the whole recording tell; the turns between rests need the matrix that
/// known turns tell. So the recording is gone through twice.
Result<CalibrationRun> calibrate(const io::Recording& recording, calib::OnlineCalibrator& calibrator,
                                 const calib::RestDetectorParams& rest, const RecordingOptions& options) {
  const calib::OnlineCalibrator at_first = calibrator;
  CalibrationRun run = calibrate(recording, calibrator, rest);
  if (options.turns.empty() && options.rates.empty()) return run;
  const auto gyr_at = [&](double t_s) { return gyr_after(t_s, run, calibrator.params().gyroscope); };
  auto known = measure(options.turns, options.rates, recording, gyr_at);
  if (!known) return tl::unexpected(known.error());
  calibrator = at_first;
  std::vector<calib::KnownTurn> turns;
  for (KnownTurnReport& t : *known) {
    t.before = calib::seen_by(calibrator.gyr_matrix(), t.turn);
    turns.push_back(t.turn);
  }
  calibrator.absorb(turns);
  const std::uint32_t refused_without = run.state.gyr_matrix.refused;
  run = calibrate(recording, calibrator, rest);
  run.refused_without = refused_without;
  for (std::size_t k = 0; k < turns.size(); ++k) {
    (*known)[k].turn = turns[k];
    (*known)[k].after = calib::seen_by(run.gyr_matrix, turns[k]);
  }
  run.known_turns = std::move(*known);
  return run;
}

/// Somigliana's formula on the ellipsoid of WGS 84.
double gravity_at(double latitude_deg) {
  const double s = std::pow(std::sin(latitude_deg * kRadPerDeg), 2);
  return 9.7803253359 * (1.0 + 0.00193185265241 * s) / std::sqrt(1.0 - 0.00669437999014 * s);
}

/// The recording's own, where its header states one that the Earth has.
std::optional<double> local_gravity_mps2(const io::Recording& recording, const std::string& path) {
  const auto stated = recording.header.find("gravity_mps2");
  if (stated == recording.header.end()) return std::nullopt;
  const double given = std::strtod(stated->second.c_str(), nullptr);
  if (given > 9.7 && given < 9.9) return given;
  tell(fmt::format("{}: {} after '# gravity_mps2:' is no gravity of the Earth (9.7 to 9.9); {} is used", path,
                   io::quote(stated->second), kStandardGravity_mps2));
  return std::nullopt;
}

}  // namespace

int calibrate_recording(const std::string& path, const std::string& json, const RecordingOptions& options) {
  auto recording = io::read_recording(path);
  if (!recording) return report(recording.error());
  if (recording->acc_mps2.empty() || recording->acc_in_counts || recording->gyr_in_counts)
    return report(
        {ErrorKind::kBadData,
         path + ": the calibration needs acc_*_mps2 or acc_*_g, and a gyroscope in rad/s or deg/s, not counts"});
  warn_if_implausible(*recording, path);
  io::DaemonConfig config;
  if (!options.config.empty()) {
    auto read = io::read_config(options.config);
    if (!read) return report(read.error());
    config = std::move(*read);
  }
  if (config.source.mount) io::mount_sensors(*recording, *config.source.mount);
  calib::OnlineCalibratorParams params = config.calibration.online;
  const auto gravity_mps2 = options.gravity_mps2   ? options.gravity_mps2
                            : options.latitude_deg ? std::optional(gravity_at(*options.latitude_deg))
                                                   : local_gravity_mps2(*recording, path);
  params.gravity_mps2 = gravity_mps2.value_or(params.gravity_mps2);
  calib::OnlineCalibrator calibrator(params, io::factory_calibration(config.sensor));
  const auto named = recording->header.find("sensor");
  std::string sensor_id = !options.sensor_id.empty()         ? options.sensor_id
                          : named != recording->header.end() ? named->second
                          : !options.config.empty()          ? config.sensor.id
                                                             : "";
  if (!options.state.empty())
    if (const auto learnt = read_state(options.state, sensor_id, calibrator); !learnt) return report(learnt.error());
  for (const auto& line : io::describe(recording->issues)) tell(fmt::format("{}: {}", path, line));
  const calib::MagLearner field_at_first = calibrator.field();
  auto calibrated = calibrate(*recording, calibrator, config.rest, options);
  if (!calibrated) return report({calibrated.error().kind, path + ": " + calibrated.error().message});
  CalibrationRun& run = *calibrated;
  if (run.has_mag && !recording->gyr_radps.empty()) learn_field_again(*recording, field_at_first, calibrator, run);
  for (const std::string& line : remarks(run.known_turns)) tell(fmt::format("{}: {}", path, line));
  run.gravity_stated = gravity_mps2.has_value() || !options.config.empty();
  Result<void> written;
  if (!json.empty())
    written = io::write_text_file(json, json_text(to_json(path, run)));
  else
    print(path, run);
  // Last: what the run found is shown even where it cannot be kept.
  if (!options.report.empty())
    if (const auto kept = io::write_text_file(options.report, calibration_html(path, run)); !kept)
      return report(kept.error());
  if (!options.output.empty()) {
    const std::string id = sensor_id.empty() ? kUnnamed : sensor_id;
    const auto kept = io::write_text_file(options.output, sensor_yaml(id, run.learnt, run.has_mag));
    if (!kept) return report(kept.error());
  }
  if (!options.state.empty())
    if (const auto kept = write_state(options.state, sensor_id, calibrator); !kept) return report(kept.error());
  return written ? 0 : report(written.error());
}

}  // namespace stillpoint::app
