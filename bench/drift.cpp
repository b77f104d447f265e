/// drift [--limits FILE] [--recordings FOLDER] [--json]: the figures by which an attitude filter gets worse without
/// anybody noticing, each against its stored value. Exit 1 when one is beyond its tolerance, 66 when FILE is absent.
/// Seeds are fixed; the figures do not depend on the machine.
#include <fmt/format.h>

#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>

#include "bench/arguments.h"
#include "bench/broad_run.h"
#include "tests/fusion/random_motion.h"
#include "tests/pipeline/simulated_run.h"
#include "tests/source_folder.h"

namespace stillpoint::bench {
namespace {

constexpr unsigned kSeeds = 20;
constexpr double kHour_s = 3600.0;

using Figures = std::map<std::string, double>;

test::MotionParams consumer_sensor() {
  test::MotionParams m;
  m.rate_hz = 100.0;
  m.gyr_bias_walk_radps_rtHz = 1e-5;
  return m;
}

/// Heading drift in deg/h without magnetometer: rms over the seeds, the first 20 s at rest, then `still` or moving.
double heading_drift(bool still, double seconds) {
  fusion::AttitudeFilterParams params;
  params.use_magnetometer = false;
  double sum = 0.0;
  for (unsigned seed = 0; seed < kSeeds; ++seed) {
    test::RandomMotion motion(consumer_sensor(), seed);
    fusion::AttitudeFilter filter(params);
    const int settle = 2000, n = settle + static_cast<int>(100.0 * seconds);
    Quat start = Quat::Identity();
    Vec3 error = Vec3::Zero();
    for (int i = 0; i < n; ++i) {
      const bool rests = still || i < settle;
      const fusion::AttitudeEstimate e = filter.step(motion.next(rests), rests);
      const Quat difference = motion.q_world_body() * quat(e.q_world_body).conjugate();
      if (i == settle) start = difference;
      error = log_quat(difference * start.conjugate());
    }
    const double drift = error.z() * kDegPerRad * kHour_s / seconds;
    sum += drift * drift / kSeeds;
  }
  return std::sqrt(sum);
}

/// Error of the gyro bias in deg/h, rms over seeds, axes and the ends of all rests after the first minute, while the
/// temperature takes its course and the bias follows it. All stages run, with their calibrator and its temperature
/// model; what they took off is the reading less the published rate.
double bias_error(double rate_hz, const std::string& motion, const std::string& temperature, unsigned seeds) {
  constexpr double kSlope_radps_per_K = 5e-5;
  const Vec3 bias_radps(0.01, -0.01, 0.005);
  const std::string simulation = fmt::format(
      "rate_hz: {}\n"
      "accelerometer: {{noise_mps2: 0.02, bias: [0, 0, 0], matrix: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}}\n"
      "gyroscope: {{noise_radps: 0.002, bias: [{}, {}, {}], matrix: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}}\n"
      "motion: {{{}}}\n"
      "environment: {{temperature: {{{}, noise_K: 0}}}}\n"
      "effects: [{{effect: gyr_temp_lin, k_radps_per_K: [{}, {}, {}]}}]\n",
      rate_hz, bias_radps.x(), bias_radps.y(), bias_radps.z(), motion, temperature, kSlope_radps_per_K,
      kSlope_radps_per_K, kSlope_radps_per_K);
  double sum = 0.0, rests = 0.0;
  for (unsigned seed = 1; seed <= seeds; ++seed) {
    Vec3 error = Vec3::Zero();
    bool rested = false;
    test::run_simulated(simulation, {}, seed, [&](const sim::SimulatedSample& truth, const pipeline::Processed& out) {
      if (truth.moving && rested && truth.sample.t_ns > 60'000'000'000) {
        sum += error.squaredNorm() / 3.0;
        rests += 1.0;
      }
      rested = !truth.moving;
      const Vec3 taken_off = vec(truth.sample.gyr_radps) - vec(out.attitude.rate_body_radps);
      error = taken_off - bias_radps - Vec3::Constant(kSlope_radps_per_K * (truth.sample.temp_degC - 25.0));
    });
  }
  return std::sqrt(sum / rests) * kDegPerRad * kHour_s;
}

/// "disturbed_attached_magnet" of "32_disturbed_attached_magnet_1cm".
std::string group_of(const std::string& trial) {
  for (const char* group : {"slow_rotation", "fast_rotation", "slow_translation", "fast_translation", "tapping",
                            "phone_vibration", "stationary_magnet", "attached_magnet"}) {
    if (trial.find(group) != std::string::npos) return group;
  }
  return "other";
}

Figures broad_figures(const std::string& folder) {
  std::map<std::string, std::vector<Score>> groups;
  for (const Trial& trial : read_trials(folder)) {
    groups[group_of(trial.name)].push_back(score(trial.recording, run_stillpoint(trial.recording, {}), false));
  }
  Figures out;
  for (const auto& [group, scores] : groups) {
    for (const Score& s : scores) {
      out["broad_" + group + "_heading_deg"] += s.heading / static_cast<double>(scores.size());
      out["broad_" + group + "_inclination_deg"] += s.inclination / static_cast<double>(scores.size());
    }
  }
  return out;
}

Figures measure(const std::string& folder) {
  Figures f = broad_figures(folder);
  f["heading_drift_at_rest_deg_per_h"] = heading_drift(true, 600.0);
  f["heading_drift_in_motion_deg_per_h"] = heading_drift(false, 300.0);
  f["bias_error_warm_up_deg_per_h"] =
      bias_error(100.0, "kind: hand, duration_s: 900", "kind: warm_up, start_degC: 25, rise_K: 20, tau_s: 300", kSeeds);
  f["bias_error_day_deg_per_h"] =
      bias_error(25.0, "kind: worn_day, duration_s: 86400", "kind: day, start_degC: 25, rise_K: 10", 1);
  return f;
}

struct Verdict {
  nlohmann::json rows = nlohmann::json::array();
  bool regressed = false;
};

/// A figure may be better by any amount and worse by its tolerance. A stored figure that could not be measured (no
/// recordings) is named and does not fail.
Verdict compare(const Figures& measured, const nlohmann::json& limits) {
  Verdict v;
  for (const auto& [name, limit] : limits.at("figures").items()) {
    const double stored = limit.at("value").get<double>(), tolerance = limit.at("tolerance").get<double>();
    const auto found = measured.find(name);
    nlohmann::json row{{"figure", name}, {"stored", stored}, {"tolerance", tolerance}};
    if (found == measured.end()) {
      row["verdict"] = "not_measured";
    } else {
      const bool worse = !(found->second <= stored + tolerance);
      row["measured"] = found->second;
      row["verdict"] = worse ? "regressed" : "ok";
      v.regressed |= worse;
    }
    v.rows.push_back(row);
  }
  return v;
}

}  // namespace
}  // namespace stillpoint::bench

int main(int argc, char** argv) {
  using namespace stillpoint::bench;
  std::string limits_file = stillpoint::in_source("bench/drift_limits.json");
  std::string folder = stillpoint::in_source("../shared/recordings/broad");
  bool json = false;
  CLI::App app{"Drift, bias and attitude error against stored limits; exit 1 when one is worse"};
  app.add_option("--limits", limits_file, "the stored figures (.json)")->capture_default_str();
  app.add_option("--recordings", folder, "folder of BROAD's recordings (.csv)")->capture_default_str();
  app.add_flag("--json", json, "on standard output, instead of the table");
  if (const auto end = parse(app, argc, argv)) return *end;
  std::ifstream in(limits_file);
  const nlohmann::json limits = nlohmann::json::parse(in, nullptr, false);
  if (limits.is_discarded() || !limits.contains("figures")) {
    fmt::print(stderr, "{}: no stored figures here (JSON with \"figures\")\n", limits_file);
    return 66;
  }
  const Verdict verdict = compare(measure(folder), limits);
  if (json) {
    fmt::print(
        "{}\n",
        nlohmann::json{{"schema", "stillpoint.drift/1"}, {"regressed", verdict.regressed}, {"figures", verdict.rows}}
            .dump(1));
  } else {
    for (const auto& row : verdict.rows) {
      fmt::print("{:<46} {:>9} stored {:8.3f} + {:6.3f}  {}\n", row["figure"].get<std::string>(),
                 row.contains("measured") ? fmt::format("{:.3f}", row["measured"].get<double>()) : "-",
                 row["stored"].get<double>(), row["tolerance"].get<double>(), row["verdict"].get<std::string>());
    }
  }
  return verdict.regressed ? 1 : 0;
}
