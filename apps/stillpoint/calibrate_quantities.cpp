#include "apps/stillpoint/calibrate_quantities.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace stillpoint::app {
namespace {

constexpr double kScaleKnown = 0.005;  // of a gyroscope's axis
constexpr double kWarmed_K = 10.0;     // less of a range says nothing of the temperature
constexpr std::array<const char*, 6> kFaces{"x up", "x down", "y up", "y down", "z up", "z down"};

double bias_sd(const TriadCalibration& t) {
  return std::sqrt(std::max(0.0, t.bias_covariance[0] + t.bias_covariance[4] + t.bias_covariance[8]) / 3.0);
}

std::vector<std::string> faces_never_seen(const CalibrationRun& run) {
  std::array<bool, 6> seen{};
  for (const auto& w : run.windows) {
    const Vec3 u = run.learnt.acc.apply(w.acc_mps2, w.temp_degC).normalized();
    for (int k = 0; k < 3; ++k) {
      seen[static_cast<std::size_t>(2 * k)] |= u[k] > 0.7;
      seen[static_cast<std::size_t>(2 * k + 1)] |= u[k] < -0.7;
    }
  }
  std::vector<std::string> out;
  for (std::size_t k = 0; k < 6; ++k)
    if (!seen[k]) out.push_back(fmt::format("lay it down with {} for five seconds", kFaces[k]));
  return out;
}

Quantity temperature(const char* name, const char* unit, const TriadCalibration& t) {
  Quantity q{.name = name, .unit = unit, .evidence = "windows", .missing = {}};
  q.used = t.windows;
  q.known = t.windows > 0 && t.temp_max_degC - t.temp_min_degC > kWarmed_K;
  if (!q.known)
    q.missing.push_back(
        t.windows == 0 ? std::string("rest at several temperatures")
                       : fmt::format("seen from {:.1f} to {:.1f} degC only: let it rest while it warms by 10 K or more",
                                     t.temp_min_degC, t.temp_max_degC));
  return q;
}

Quantity gyr_matrix(const CalibrationRun& run) {
  Quantity q{.name = "gyroscope, matrix", .unit = "-", .evidence = "turns", .missing = {}};
  const auto& state = run.state.gyr_matrix;
  q.sd = run.state.gyr_matrix_sd;
  q.used = state.published.segments;
  q.refused = state.refused;
  if (!run.known_turns.empty() && q.refused > run.refused_without)
    q.missing.push_back(fmt::format(
        "evidence contradicts: by the turns of --turn and --rate {} turns between rests are refused, without "
        "them {}; one of the stated angles may be another",
        q.refused, run.refused_without));
  if (q.refused > q.used)
    q.missing.push_back(
        fmt::format("evidence contradicts: {} of {} turns are refused; an axis may be mirrored or two exchanged: see "
                    "calibrate --mount",
                    q.refused, q.refused + q.used));
  for (int axis = 0; axis < 3; ++axis) {
    const double sd = std::sqrt(std::max(0.0, run.gyr_matrix.covariance(4 * axis, 4 * axis)));
    if (sd > kScaleKnown)
      q.missing.push_back(fmt::format(
          "scale of {0} is known to {1:.2g} only: turn it by a quarter about its {0} axis, that axis level, and rest "
          "before and after, or once around and state so with --turn",
          "xyz"[axis], sd));
  }
  q.known = q.missing.empty();
  return q;
}

}  // namespace

std::vector<Quantity> quantities(const CalibrationRun& run) {
  const CalibrationSnapshot& c = run.learnt;
  std::vector<Quantity> out;
  const bool acc_ok = c.acc.status == CalibrationStatus::kOk;
  const auto faces = acc_ok ? std::vector<std::string>() : faces_never_seen(run);
  out.push_back(
      {"accelerometer, bias", "m/s^2", bias_sd(c.acc), acc_ok, c.acc.windows, run.state.acc.refused, "windows", faces});
  out.push_back({"accelerometer, matrix", "m/s^2 of the norm", c.acc.norm_sd, acc_ok, c.acc.windows,
                 run.state.acc.refused, "windows", faces});
  out.push_back(temperature("accelerometer, temperature", "m/s^2/K", c.acc));
  Quantity bias{"gyroscope, bias", "rad/s",
                bias_sd(c.gyr),    c.gyr.status == CalibrationStatus::kOk,
                c.gyr.windows,     run.state.gyr.refused,
                "windows",         {}};
  if (run.state.gyr.seen.count <= 1 && !run.has_mag)
    bias.missing.emplace_back("a second attitude: in one, a turn about the vertical cannot be told from an offset");
  if (run.state.gyr.rivalry.open != 0)
    bias.missing.emplace_back("evidence contradicts: rest in three other attitudes decides which offset holds");
  out.push_back(bias);
  out.push_back(gyr_matrix(run));
  out.push_back(temperature("gyroscope, temperature", "rad/s/K", c.gyr));
  if (!run.has_mag) return out;
  Quantity iron{"magnetometer, iron and matrix",
                "uT",
                c.mag.norm_sd,
                c.mag.status == CalibrationStatus::kOk,
                c.mag.windows,
                0,
                "turns of the field",
                {}};
  if (c.mag.status == CalibrationStatus::kTooFewWindows)
    iron.missing.push_back(fmt::format("{} turns of the field; thirty are the least", c.mag.windows));
  if (c.mag.status == CalibrationStatus::kNotObservable)
    iron.missing.emplace_back("turns about more axes, away from iron");
  out.push_back(iron);
  return out;
}

std::vector<std::string> missing(const CalibrationRun& run) {
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
  for (const Quantity& q : quantities(run))
    for (const std::string& what : q.missing) {
      const std::string line = q.name.substr(0, q.name.find(',')) + ": " + what;
      if (std::find(out.begin(), out.end(), line) == out.end()) out.push_back(line);
    }
  if (!run.gravity_stated)
    out.push_back(fmt::format(
        "where it was made: gravity is taken for {} m/s^2 and is up to 0.026 off elsewhere (--gravity, --latitude); "
        "all scales are off by as much",
        run.gravity_mps2));
  return out;
}

}  // namespace stillpoint::app
