/// `stillpoint calibrate --recording`: the daemon's rest detection and calibration over a file, with what they could
/// not see.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <span>

#include "apps/stillpoint/calibrate.h"
#include "apps/stillpoint/commands.h"
#include "apps/stillpoint/progress.h"
#include "calib_online/field_turns.h"
#include "calib_online/online_calibrator.h"
#include "calib_online/rest_detector.h"
#include "io/recording.h"
#include "io/state_file.h"

namespace stillpoint::app {
namespace {

using Json = nlohmann::ordered_json;

const std::string kUnnamed = "unnamed";  // the state of a sensor that no recording named

struct Fault {
  double t_s;
  const char* sensor;
  CalibrationStatus status;
};

struct Outcome {
  std::vector<calib::Window> windows;
  std::map<std::string, double> refused_s;  ///< seconds by reason
  CalibrationSnapshot factory, learnt;
  std::vector<Fault> faults;                  ///< where each begins
  std::array<CalibrationStatus, 3> status{};  ///< of acc, gyr, mag now
  double gravity_mps2 = kStandardGravity_mps2;
  double duration_s = 0.0;
  double middle_norm_mps2 = 0.0;  ///< median of the readings
  bool has_mag = false;
};

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
    return refused(fmt::format("it is of the sensor '{}', the recording of '{}'", file->sensor_id, sensor_id));
  calib::OnlineCalibrator::State state;
  if (file->payload.size() != sizeof state) return refused("of another version");
  std::memcpy(&state, file->payload.data(), sizeof state);
  if (!calibrator.restore(state)) return refused("of another version, or not finite");
  if (sensor_id.empty()) sensor_id = file->sensor_id;
  return {};
}

Result<void> write_state(const std::string& path, const std::string& sensor_id,
                         const calib::OnlineCalibrator& calibrator) {
  const auto state = calibrator.state();
  const auto bytes = std::as_bytes(std::span(&state, 1));
  return io::write_state_file(path, {sensor_id.empty() ? kUnnamed : sensor_id, {bytes.begin(), bytes.end()}});
}

/// A sensor that begins to be stuck, clipped or another one.
void note_faults(const CalibrationSnapshot& now, double t_s, Outcome& run) {
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
  if (norms.empty()) return 0.0;
  const auto middle = norms.begin() + static_cast<std::ptrdiff_t>(norms.size() / 2);
  std::nth_element(norms.begin(), middle, norms.end());
  return *middle;
}

Outcome calibrate(const io::Recording& recording, calib::OnlineCalibrator& calibrator, double gravity_mps2) {
  Outcome run;
  run.gravity_mps2 = gravity_mps2;
  run.factory = CalibrationSnapshot{};
  calib::RestDetectorParams params;
  params.gravity_mps2 = gravity_mps2;
  calib::RestDetector detector(params);
  calib::FieldTurnFinder turns;
  Progress progress("calibrating");
  for (std::size_t row = 0; row < recording.size(); ++row) {
    if (row % 4096 == 0) progress.at(static_cast<double>(row) / static_cast<double>(recording.size()));
    const RawSample sample = recording.sample(row);
    const auto window = detector.push(sample, calibrator.snapshot());
    if (const auto turn = turns.push(sample, 0, calibrator.snapshot())) calibrator.absorb(*turn);
    const double step_s = row > 0 ? recording.t_s(row) - recording.t_s(row - 1) : 0.0;
    run.refused_s[std::string(calib::name(detector.last_refusal()))] += step_s;
    if (!window) continue;
    if (window->has != 0) run.windows.push_back(*window);
    calibrator.absorb(*window);
    note_faults(calibrator.snapshot(), recording.t_s(row), run);
  }
  run.middle_norm_mps2 = middle_norm(recording.acc_mps2);
  run.learnt = calibrator.snapshot();
  run.has_mag = !recording.mag_uT.empty();
  run.duration_s = recording.t_s(recording.size() - 1) - recording.t_s(0);
  return run;
}

/// What would have to be seen for the rest to be known.
std::vector<std::string> missing(const Outcome& run) {
  std::vector<std::string> out;
  if (run.windows.empty()) {
    std::string most = "none";
    double longest_s = 0.0;
    for (const auto& [reason, s] : run.refused_s)
      if (s > longest_s) longest_s = s, most = reason;
    out.push_back(fmt::format("no window of rest; most of the time: {}", most));
    const double times_g = run.middle_norm_mps2 / run.gravity_mps2;
    if (run.middle_norm_mps2 > 0.0 && (times_g < 0.5 || times_g > 2.0))
      out.push_back(
          fmt::format("a specific force near gravity: half of the readings are below {:.3g} m/s^2; is the unit in the "
                      "column's name (acc_x_mps2, acc_x_g) that of the numbers?",
                      run.middle_norm_mps2));
    return out;
  }
  std::array<int, 6> faces{};
  std::size_t with_gyr = 0, turned = 0;
  for (const auto& w : run.windows) {
    const Vec3 u = run.learnt.acc.apply(w.acc_mps2, w.temp_degC).normalized();
    for (int k = 0; k < 3; ++k) {
      if (u[k] > 0.7) ++faces[static_cast<std::size_t>(2 * k)];
      if (u[k] < -0.7) ++faces[static_cast<std::size_t>(2 * k + 1)];
    }
    with_gyr += (w.has & kGyr) != 0;
    turned += w.rotation_valid && 2.0 * std::acos(std::min(1.0, std::abs(w.q_previous_this[0]))) > 0.5;
  }
  constexpr std::array<const char*, 6> kFaces{"x up", "x down", "y up", "y down", "z up", "z down"};
  for (std::size_t k = 0; k < 6; ++k)
    if (faces[k] == 0) out.push_back(fmt::format("no window with {}", kFaces[k]));
  if (with_gyr == 0) out.emplace_back("no window in which the gyroscope was surely at rest");
  if (turned < 3)
    out.push_back(fmt::format(
        "{} turns between windows; the gyro's matrix and the angles between the sensors need turns about three axes",
        turned));
  if (run.has_mag && run.learnt.mag.status == CalibrationStatus::kTooFewWindows)
    out.push_back(fmt::format("{} turns of the magnetic field; thirty are the least", run.learnt.mag.windows));
  if (run.has_mag && run.learnt.mag.status == CalibrationStatus::kNotObservable)
    out.emplace_back("turns of the magnetic field about more axes, away from iron");
  return out;
}

struct Norms {
  double before_mps2 = 0.0, after_mps2 = 0.0;
};
/// rms of the norm's error over the windows, with the factory calibration and with what was learnt.
Norms norms(const Outcome& run) {
  Norms n;
  for (const auto& w : run.windows) {
    n.before_mps2 += std::pow(run.factory.acc.apply(w.acc_mps2, w.temp_degC).norm() - run.gravity_mps2, 2);
    n.after_mps2 += std::pow(run.learnt.acc.apply(w.acc_mps2, w.temp_degC).norm() - run.gravity_mps2, 2);
  }
  const double count = std::max<double>(1.0, static_cast<double>(run.windows.size()));
  return {std::sqrt(n.before_mps2 / count), std::sqrt(n.after_mps2 / count)};
}

Json to_json(const TriadCalibration& t) {
  Json j;
  j["status"] = name(t.status);
  j["windows"] = t.windows;
  j["bias"] = t.bias;
  j["bias_sd"] = nullptr;  // unknown is not zero
  if (t.bias_covariance[0] > 0.0)
    j["bias_sd"] = {std::sqrt(t.bias_covariance[0]), std::sqrt(t.bias_covariance[4]), std::sqrt(t.bias_covariance[8])};
  j["bias_per_K"] = t.bias_per_K;
  j["bias_per_K2"] = t.bias_per_K2;
  j["temp_ref_degC"] = t.temp_ref_degC;
  j["temp_range_degC"] = {t.temp_min_degC, t.temp_max_degC};
  j["matrix"] = Json::array();
  for (std::size_t r = 0; r < 3; ++r)
    j["matrix"].push_back({t.matrix[3 * r], t.matrix[3 * r + 1], t.matrix[3 * r + 2]});
  j["norm_sd"] = t.norm_sd > 0.0 ? Json(t.norm_sd) : Json();
  return j;
}

Json to_json(const std::string& path, const Outcome& run) {
  const Norms n = norms(run);
  Json j;
  j["recording"] = path;
  j["duration_s"] = run.duration_s;
  j["windows"] = run.windows.size();
  j["seconds_by_verdict"] = run.refused_s;
  j["faults"] = Json::array();
  for (const Fault& f : run.faults)
    j["faults"].push_back({{"time_s", f.t_s}, {"sensor", f.sensor}, {"status", name(f.status)}});
  j["norm_rms_error_mps2"] = {{"before", n.before_mps2}, {"after", n.after_mps2}};
  j["accelerometer"] = to_json(run.learnt.acc);
  j["gyroscope"] = to_json(run.learnt.gyr);
  if (run.has_mag) j["magnetometer"] = to_json(run.learnt.mag);
  j["missing"] = missing(run);
  return j;
}

/// " +- 0.0012", or that it is not known: nothing learnt is not the same as no error.
std::string plus_minus(double variance, double factor) {
  return variance > 0.0 ? fmt::format("+- {:.4f}", factor * std::sqrt(variance)) : std::string("(sd unknown)");
}

void print(const char* sensor, const char* evidence, const char* unit, double factor, const TriadCalibration& t) {
  fmt::print("\n{}: {}, {} {}\n", sensor, name(t.status), t.windows, evidence);
  for (std::size_t k = 0; k < 3; ++k) {
    fmt::print("  bias {}  {:10.4f} {} {}", "xyz"[k], factor * t.bias[k], plus_minus(t.bias_covariance[4 * k], factor),
               unit);
    if (t.temp_max_degC > t.temp_min_degC) fmt::print("   {:+.5f} {}/K", factor * t.bias_per_K[k], unit);
    fmt::print("\n");
  }
  for (std::size_t r = 0; r < 3; ++r)
    fmt::print("  matrix  {:10.6f} {:10.6f} {:10.6f}\n", t.matrix[3 * r], t.matrix[3 * r + 1], t.matrix[3 * r + 2]);
}

void print(const std::string& path, const Outcome& run) {
  fmt::print("{}: {:.1f} s, {} windows of rest\n", path, run.duration_s, run.windows.size());
  for (const auto& [reason, s] : run.refused_s)
    if (s > 0.0) fmt::print("  {:8.1f} s  {}\n", s, reason == "none" ? "at rest" : reason);
  for (const Fault& f : run.faults) fmt::print("  at {:.1f} s the {} is {}\n", f.t_s, f.sensor, name(f.status));
  print("accelerometer", "windows", "m/s^2", 1.0, run.learnt.acc);
  if (run.learnt.acc.norm_sd > 0.0) {
    const Norms n = norms(run);
    fmt::print("  norm known to {:.4f} m/s^2 (rms over the sphere); windows off by {:.4f} before, {:.4f} after\n",
               run.learnt.acc.norm_sd, n.before_mps2, n.after_mps2);
  } else {
    fmt::print("  norm: unknown, nothing learnt\n");
  }
  print("gyroscope", "windows", "deg/s", kDegPerRad, run.learnt.gyr);
  if (run.has_mag) print("magnetometer", "turns of the field", "uT", 1.0, run.learnt.mag);
  fmt::print("\nstill missing:\n");
  const auto lacks = missing(run);
  for (const auto& line : lacks) fmt::print("  {}\n", line);
  if (lacks.empty()) fmt::print("  nothing\n");
}

}  // namespace

int calibrate_recording(const std::string& path, const JsonTarget& json, const std::string& state) {
  const auto recording = io::read_recording(path);
  if (!recording) return report(recording.error());
  if (recording->acc_mps2.empty() || recording->acc_in_counts || recording->gyr_in_counts)
    return report(
        {ErrorKind::kBadData,
         path + ": the calibration needs acc_*_mps2 or acc_*_g, and a gyroscope in rad/s or deg/s, not counts"});
  double gravity_mps2 = kStandardGravity_mps2;
  if (const auto it = recording->header.find("gravity_mps2"); it != recording->header.end()) {
    const double given = std::atof(it->second.c_str());
    if (given > 9.7 && given < 9.9) gravity_mps2 = given;
  }
  calib::OnlineCalibratorParams params;
  params.gravity_mps2 = gravity_mps2;
  calib::OnlineCalibrator calibrator(params, CalibrationSnapshot{});
  const auto named = recording->header.find("sensor");
  std::string sensor_id = named != recording->header.end() ? named->second : "";
  if (!state.empty())
    if (const auto learnt = read_state(state, sensor_id, calibrator); !learnt) return report(learnt.error());
  for (const auto& line : io::describe(recording->issues)) fmt::print(stderr, "{}: {}\n", path, line);
  const Outcome run = calibrate(*recording, calibrator, gravity_mps2);
  int failed = 0;
  if (json)
    failed = write_json(to_json(path, run).dump(2, ' ', false, Json::error_handler_t::replace) + "\n", *json);
  else
    print(path, run);
  // Last: what the run found is shown even where it cannot be kept.
  if (!state.empty())
    if (const auto kept = write_state(state, sensor_id, calibrator); !kept) return report(kept.error());
  return failed;
}

}  // namespace stillpoint::app
