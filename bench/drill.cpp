/// drill [--seeds N] [--first-seed N] [--on SET] [--faults NAME...] [--check FILE] [--json]: every fault of
/// drill_faults.h in a hand's motion, or in each recording of a set, through all stages: whether and when it is seen,
/// what the attitude loses, whether that was stated, and how soon it is whole again. --check fails where a fault misses
/// what is required of every fault; FILE lists those that are known to, with the figures that they must not fall
/// behind.
#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "bench/arguments.h"
#include "bench/drill_faults.h"
#include "bench/portfolio_run.h"
#include "bench/portfolio_sets.h"
#include "core/units.h"
#include "tests/source_folder.h"

namespace stillpoint::bench {
namespace {

constexpr Interval kFault{60.0, 80.0};
constexpr double kDeceived_s = 2.0;  ///< so long may a status say ok beyond three standard deviations
constexpr double kSettled_s = 2.0;   ///< so long must it be well again to have recovered

struct Options {
  unsigned seeds = 50, first_seed = 1;
  std::vector<std::string> faults;
  std::string known_shortfalls;
  std::string set, recordings = stillpoint::in_source("../shared/recordings");
  bool json = false;
};

/// Required of every fault; shares of runs, and of time for `inside`.
struct Required {
  double seen = 0.99, inside = 0.98, deceived = 0.0;
};

/// One run of one seed.
struct Run {
  double seen_s = INFINITY;  ///< from the start of the fault
  bool blamed = false;       ///< the health of the sensor itself
  double worst_deg = 0.0;    ///< tilt from the start of the fault on
  double inside = 0.0;       ///< share of attitudes from the start of the fault on inside three standard deviations
  double longest_deceived_s = 0.0;
  double recovered_s = INFINITY;  ///< from the end of the fault: ok and inside, for kSettled_s at least
};

const SensorHealth& of(const SensorsHealth& health, SamplePart part) {
  return part == kAcc ? health.acc : part == kGyr ? health.gyr : part == kMag ? health.mag : health.temp;
}

/// What the run so far says to a subscriber.
bool says_so(const pipeline::Processed& p) {
  return pipeline::to_message(p).status != AttitudeStatus::kOk || p.health.worst() != Health::kOk ||
         p.health.mag.state == Health::kAbsent || p.attitude.heading != HeadingReference::kMagnetic;
}

/// By row; null where the reference says nothing.
std::vector<const Truth*> truths_by_row(const Series& series) {
  std::vector<const Truth*> of_row(series.rows.size(), nullptr);
  std::size_t row = 0;
  for (const Truth& truth : series.truths) {
    while (row < of_row.size() && series.rows[row].t_ns < truth.t_ns) ++row;
    if (row < of_row.size() && series.rows[row].t_ns == truth.t_ns) of_row[row] = &truth;
  }
  return of_row;
}

Run run_once(const DrillFault* fault, unsigned seed, Series series) {
  std::mt19937 random(seed);
  const std::vector<const Truth*> truth_of = truths_by_row(series);
  for (std::size_t k = 0; k < series.rows.size(); ++k) series.rows[k].sequence = k;  // a fault moves and drops rows
  const std::int64_t zero_ns = series.rows.front().t_ns;
  if (fault != nullptr) fault->apply(series.rows, kFault, random);
  Run run;
  calib::OnlineCalibrator calibrator({}, series.start);
  pipeline::DirectLink link(calibrator);
  pipeline::Stages stages({}, calibrator.snapshot());
  pipeline::Processed p;
  double judged = 0.0, inside = 0.0, deceived_from_s = INFINITY, well_from_s = INFINITY;
  for (const RawSample& row : series.rows) {
    if (stages.process(row, p, link) == pipeline::StageStatus::kDrop) continue;
    const Truth* truth = truth_of[p.sample.sequence];
    if (truth == nullptr) continue;
    const double t_s = in_seconds(truth->t_ns - zero_ns);
    if (t_s < kFault.from_s) continue;
    const Judged j = judge(truth->q_world_body, p);
    const bool held = j.tilt_inside && j.heading_inside;
    judged += 1.0;
    inside += held ? 1.0 : 0.0;
    run.worst_deg = std::max(run.worst_deg, j.tilt_rad * kDegPerRad);
    if (says_so(p)) run.seen_s = std::min(run.seen_s, t_s - kFault.from_s);
    run.blamed |= fault != nullptr && of(p.health, fault->part).state != Health::kOk;
    deceived_from_s = j.ok && !held ? std::min(deceived_from_s, t_s) : INFINITY;
    run.longest_deceived_s = std::max(run.longest_deceived_s, t_s - deceived_from_s);
    well_from_s = j.ok && held && t_s >= kFault.to_s ? std::min(well_from_s, t_s) : INFINITY;
    if (t_s - well_from_s >= kSettled_s) run.recovered_s = std::min(run.recovered_s, well_from_s - kFault.to_s);
  }
  run.inside = inside / std::max(judged, 1.0);
  return run;
}

double quantile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

/// Over all seeds; shares from 0 to 1.
struct Figures {
  double seen = 0.0, blamed = 0.0, inside = 0.0, deceived = 0.0, recovered = 0.0;
  double seen_s = 0.0, worst_deg = 0.0, recovered_s = 0.0;  ///< medians
};

Figures figures(const std::vector<Run>& runs, double required_s) {
  Figures f;
  std::vector<double> seen_s, worst_deg, recovered_s;
  for (const Run& r : runs) {
    f.seen += r.seen_s <= required_s ? 1.0 : 0.0;
    f.blamed += r.blamed ? 1.0 : 0.0;
    f.inside += r.inside;
    f.deceived += r.longest_deceived_s > kDeceived_s ? 1.0 : 0.0;
    f.recovered += std::isfinite(r.recovered_s) ? 1.0 : 0.0;
    seen_s.push_back(r.seen_s);
    worst_deg.push_back(r.worst_deg);
    recovered_s.push_back(r.recovered_s);
  }
  for (double* x : {&f.seen, &f.blamed, &f.inside, &f.deceived, &f.recovered}) *x /= static_cast<double>(runs.size());
  f.seen_s = quantile(seen_s, 0.5);
  f.worst_deg = quantile(worst_deg, 0.5);
  f.recovered_s = quantile(recovered_s, 0.5);
  return f;
}

void print_head() {
  fmt::print("{:<26} {:>7} {:>7} {:>8} {:>7} {:>9} {:>9} {:>9} {:>10} {:>11}\n", "fault, 60 to 80 s", "limit s",
             "seen %", "median s", "named %", "tilt deg", "inside %", "misled %", "recovers %", "median s");
}

void print_line(const std::string& name, double required_s, const Figures& f) {
  fmt::print("{:<26} {:>7} {:7.0f} {:8.2f} {:7.0f} {:9.1f} {:9.1f} {:9.0f} {:10.0f} {:11.1f}\n", name,
             required_s > 0.0 ? fmt::format("{:.1f}", required_s) : "-", 100 * f.seen, f.seen_s, 100 * f.blamed,
             f.worst_deg, 100 * f.inside, 100 * f.deceived, 100 * f.recovered, f.recovered_s);
}

nlohmann::json json_of(const Figures& f) {
  return {{"seen", f.seen},           {"seen_median_s", f.seen_s},
          {"named", f.blamed},        {"worst_tilt_median_deg", f.worst_deg},
          {"inside", f.inside},       {"misled", f.deceived},
          {"recovered", f.recovered}, {"recovered_median_s", f.recovered_s}};
}

/// What falls behind; empty: nothing.
std::string shortfall(const Figures& f, bool must_be_seen, const nlohmann::json& known) {
  Required required;
  if (known.is_object())
    required = {known.value("seen", required.seen), known.value("inside", required.inside),
                known.value("misled", required.deceived)};
  constexpr double kRounding = 1e-9;
  std::string out;
  if (must_be_seen && f.seen < required.seen - kRounding)
    out += fmt::format(" seen {:.3f} < {}", f.seen, required.seen);
  if (f.inside < required.inside - kRounding) out += fmt::format(" inside {:.3f} < {}", f.inside, required.inside);
  if (f.deceived > required.deceived + kRounding)
    out += fmt::format(" misled {:.3f} > {}", f.deceived, required.deceived);
  return out;
}

/// One run a seed, or one a recording of the set.
std::vector<Run> runs_of(const DrillFault* fault, const Options& options, const std::vector<Series>& recorded) {
  std::vector<Run> runs;
  unsigned seed = options.first_seed;
  for (const Series& series : recorded) runs.push_back(run_once(fault, seed++, series));
  for (; options.set.empty() && seed < options.first_seed + options.seeds; ++seed)
    runs.push_back(run_once(fault, seed, hand_series(seed)));
  return runs;
}

/// Those of the set that are long enough for the fault and for half a minute after it, and have a reference in their
/// rows.
std::vector<Series> recorded_of(const Options& options) {
  std::vector<Series> out;
  if (options.set.empty()) return out;
  for (PortfolioSet& set :
       recorded_sets(options.recordings, [&](const std::string& name) { return name == options.set; }))
    for (Series& series : set.series) {
      const double length_s = in_seconds(series.rows.back().t_ns - series.rows.front().t_ns);
      const auto truths = truths_by_row(series);
      const auto known = truths.size() - static_cast<std::size_t>(std::count(truths.begin(), truths.end(), nullptr));
      if (length_s > kFault.to_s + 30.0 && 2 * known > truths.size()) out.push_back(std::move(series));
    }
  return out;
}

int run(const Options& options) {
  const std::vector<Series> recorded = recorded_of(options);
  if (!options.set.empty() && recorded.empty()) {
    fmt::print(stderr, "{}: no recording of 110 s with a reference in its rows in the set '{}' ({})\n",
               options.recordings, options.set, "broad, phones, phones magnets, phones running");
    return 2;
  }
  nlohmann::json known = nlohmann::json::object();
  if (!options.known_shortfalls.empty()) known = nlohmann::json::parse(std::ifstream(options.known_shortfalls));
  nlohmann::json out{{"schema", "stillpoint.drill/1"}, {"seeds", options.seeds}, {"faults", nlohmann::json::object()}};
  std::vector<std::string> failed;
  const auto wanted = [&](const std::string& name) {
    return options.faults.empty() ||
           std::find(options.faults.begin(), options.faults.end(), name) != options.faults.end();
  };
  const auto measure = [&](const std::string& name, const DrillFault* fault) {
    if (!wanted(name)) return;
    const double required_s = fault != nullptr ? fault->seen_s : 0.0;
    const Figures f = figures(runs_of(fault, options, recorded), required_s);
    if (!options.json) print_line(name, required_s, f);
    out["faults"][name] = json_of(f);
    const std::string behind = shortfall(f, required_s > 0.0, known.value(name, nlohmann::json()));
    if (!behind.empty()) failed.push_back(name + ":" + behind);
  };
  if (!options.json) print_head();
  measure("none", nullptr);
  for (const DrillFault& fault : drill_faults()) measure(fault.name, &fault);
  if (options.json) fmt::print("{}\n", out.dump(1));
  if (options.known_shortfalls.empty()) return 0;
  for (const std::string& line : failed) fmt::print(stderr, "{}\n", line);
  return failed.empty() ? 0 : 1;
}

}  // namespace
}  // namespace stillpoint::bench

int main(int argc, char** argv) {
  using namespace stillpoint::bench;
  Options options;
  CLI::App app{"Every fault of a sensor, a bus and a clock: seen, stated, recovered from?"};
  app.add_option("--seeds", options.seeds, "of each fault")->capture_default_str();
  app.add_option("--first-seed", options.first_seed)->capture_default_str();
  app.add_option("--on", options.set, "a set of recordings, one run each, instead of the simulated hand");
  app.add_option("--recordings", options.recordings, "their folder")->capture_default_str();
  app.add_option("--faults", options.faults, "names; default: all, and none");
  app.add_option("--check", options.known_shortfalls,
                 "fail where a fault falls behind what is required, or behind FILE");
  app.add_flag("--json", options.json, "on standard output, instead of the table");
  if (const auto end = parse(app, argc, argv)) return *end;
  return run(options);
}
