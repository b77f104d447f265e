#include <fmt/format.h>

#include "bench/portfolio_sets.h"
#include "core/result.h"
#include "core/units.h"
#include "io/simulation_yaml.h"
#include "simulation/simulator.h"

namespace stillpoint::bench {
namespace {

/// A consumer part as its data sheet has it: offsets of 1 deg/s, scale within 1 %, noise of a few mdps/rtHz.
constexpr char kSensor[] =
    "rate_hz: 100\n"
    "accelerometer: {noise_mps2: 0.03, bias: [0.1, -0.08, 0.12], matrix: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}\n"
    "gyroscope: {noise_radps: 0.002, bias: [0.017, -0.01, 0.012], matrix: [[1.008, 0, 0.004], [0, 0.994, 0], [0, 0, "
    "1]]}\n"
    "magnetometer: {noise_uT: 0.4, bias: [12, -9, 15], matrix: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}\n";
constexpr char kHand[] = "motion: {kind: hand, duration_s: 150}\n";

struct Scenario {
  const char* name;
  std::string yaml;
  bool starts_in_motion = false;
  double jump_radps = 0.0;  ///< of the gyroscope's offset at 75 s
};

std::vector<Scenario> scenarios() {
  const std::string sensor = kSensor;
  return {
      {"hand", sensor + kHand},
      {"starts in motion", sensor + kHand, true},
      {"bias jump 1 deg/s", sensor + kHand, false, kRadPerDeg},
      {"drone", sensor + "motion: {kind: drone, duration_s: 150, vibration_hz: 60, vibration_mps2: 8}\n"},
      {"bent field", sensor + kHand + "environment: {iron: [{moment_Am2: [0, 0, 10], start_m: [0.6, 0, 0]}]}\n"},
      {"centrifuge", sensor + "motion: {kind: turntable, duration_s: 150, max_bout_s: 30, rate_radps: 3}\n" +
                         "effects: [{effect: acc_lever, r_m: [0.4, 0.2, 0.3]}]\n"},
      {"car 2.5 m/s2", sensor + "motion: {kind: vehicle, duration_s: 300, speed_mps: 15}\n"},
  };
}

Series simulate(const Scenario& scenario, unsigned seed) {
  const auto simulation = io::parse_simulation(scenario.yaml, scenario.name);
  SP_EXPECTS(simulation.has_value());
  Series series{fmt::format("{} {}", scenario.name, seed), {}, {}, {}};
  bool begun = !scenario.starts_in_motion;
  double moved_s = 0.0;
  for (const sim::SimulatedSample& s : sim::simulate(*simulation, seed)) {
    moved_s = s.moving ? moved_s + 0.01 : 0.0;
    begun |= moved_s > 1.0;
    if (!begun) continue;
    series.rows.push_back(s.sample);
    const double t_s = in_seconds(s.sample.t_ns);
    if (t_s > 75.0)
      for (double& x : series.rows.back().gyr_radps) x += scenario.jump_radps;
    const double from_start_s = in_seconds(s.sample.t_ns - series.rows.front().t_ns);
    series.truths.push_back({s.sample.t_ns, s.true_q_world_body, from_start_s >= 5.0});
  }
  return series;
}

}  // namespace

Series hand_series(unsigned seed) { return simulate(scenarios().front(), seed); }

std::vector<PortfolioSet> simulated_sets(unsigned seeds, const Wanted& wanted) {
  std::vector<PortfolioSet> sets;
  for (const Scenario& scenario : scenarios()) {
    if (!wanted(scenario.name)) continue;
    PortfolioSet set{scenario.name, "", 5.0, {}};
    for (unsigned seed = 1; seed <= seeds; ++seed) set.series.push_back(simulate(scenario, seed));
    sets.push_back(std::move(set));
  }
  return sets;
}

}  // namespace stillpoint::bench
