#include "apps/stillpoint/calibrate_report.h"

#include "apps/stillpoint/calibrate_quantities.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace stillpoint::app {
namespace {

using Json = nlohmann::ordered_json;

struct Norms {
  double before_mps2 = 0.0, after_mps2 = 0.0;
};
/// rms of the norm's error over the windows, with the factory calibration and with what was learnt.
Norms norms(const CalibrationRun& run) {
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

/// Of each element, row by row.
Json matrix_sd(const calib::GyroMatrixFit& fit) {
  Json rows = Json::array();
  for (int r = 0; r < 3; ++r) {
    rows.push_back(Json::array());
    for (int c = 0; c < 3; ++c) rows.back().push_back(std::sqrt(fit.covariance(3 * r + c, 3 * r + c)));
  }
  return rows;
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

}  // namespace

Json to_json(const std::string& path, const CalibrationRun& run) {
  const Norms n = norms(run);
  Json j;
  j["recording"] = path;
  j["duration_s"] = run.duration_s;
  j["windows"] = run.windows.size();
  j["seconds_by_verdict"] = run.refused_s;
  j["faults"] = Json::array();
  for (const CalibrationFault& f : run.faults)
    j["faults"].push_back({{"time_s", f.t_s}, {"sensor", f.sensor}, {"status", name(f.status)}});
  j["norm_rms_error_mps2"] = {{"before", n.before_mps2}, {"after", n.after_mps2}};
  j["accelerometer"] = to_json(run.learnt.acc);
  j["gyroscope"] = to_json(run.learnt.gyr);
  j["gyroscope"]["matrix_sd"] = matrix_sd(run.gyr_matrix);
  j["known_turns"] = to_json(run.known_turns);
  if (run.has_mag) j["magnetometer"] = to_json(run.learnt.mag);
  j["gravity_mps2"] = {{"used", run.gravity_mps2}, {"stated", run.gravity_stated}};
  j["quantities"] = Json::array();
  for (const Quantity& q : quantities(run))
    j["quantities"].push_back({{"name", q.name},
                               {"unit", q.unit},
                               {"known", q.known},
                               {"sd", q.sd > 0.0 ? Json(q.sd) : Json()},
                               {q.evidence, q.used},
                               {"refused", q.refused},
                               {"missing", q.missing}});
  j["missing"] = missing(run);
  return j;
}

void print(const std::string& path, const CalibrationRun& run) {
  fmt::print("{}: {:.1f} s, {} windows of rest\n", path, run.duration_s, run.windows.size());
  for (const auto& [reason, s] : run.refused_s)
    if (s > 0.0) fmt::print("  {:8.1f} s  {}\n", s, reason == "none" ? "at rest" : reason);
  for (const CalibrationFault& f : run.faults)
    fmt::print("  at {:.1f} s the {} is {}\n", f.t_s, f.sensor, name(f.status));
  print("accelerometer", "windows", "m/s^2", 1.0, run.learnt.acc);
  if (run.learnt.acc.norm_sd > 0.0) {
    const Norms n = norms(run);
    fmt::print("  norm known to {:.4f} m/s^2 (rms over the sphere); windows off by {:.4f} before, {:.4f} after\n",
               run.learnt.acc.norm_sd, n.before_mps2, n.after_mps2);
  } else {
    fmt::print("  norm: unknown, nothing learnt\n");
  }
  print("gyroscope", "windows", "deg/s", kDegPerRad, run.learnt.gyr);
  for (const KnownTurnReport& t : run.known_turns)
    fmt::print("  turn from {:g} to {:g} s: {}\n", t.stated.begin_s, t.stated.end_s, describe(t));
  if (run.has_mag) print("magnetometer", "turns of the field", "uT", 1.0, run.learnt.mag);
  fmt::print("\n");
  for (const Quantity& q : quantities(run))
    fmt::print("{:<30} {:<9} {} of {} {} refused{}\n", q.name, q.known ? "known" : "not yet", q.refused,
               q.used + q.refused, q.evidence, q.sd > 0.0 ? fmt::format(", sd {:.3g} {}", q.sd, q.unit) : "");
  fmt::print("\nstill missing:\n");
  const auto lacks = missing(run);
  for (const auto& line : lacks) fmt::print("  {}\n", line);
  if (lacks.empty()) fmt::print("  nothing\n");
}

}  // namespace stillpoint::app
