/// portfolio [--recordings FOLDER] [--config FILE] [--sets NAME...] [--seeds N] [--each] [--smooth] [--check FILE]
/// [--json]: the attitude over every kind of data at hand, one parameter set, causal unless smoothed, without
/// prediction: errors, the peer's errors, and the share of time in which the stated covariance holds the error.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "bench/arguments.h"
#include "bench/portfolio_check.h"
#include "bench/portfolio_sets.h"
#include "io/config.h"
#include "tests/source_folder.h"

namespace stillpoint::bench {
namespace {

struct Options {
  std::string recordings = stillpoint::in_source("../shared/recordings");
  std::string config, limits;
  std::vector<std::string> sets;
  double begin_s = 0.0;
  unsigned seeds = 20;
  bool each = false, json = false, smooth = false;
  [[nodiscard]] Way way() const { return smooth ? Way::kSmoothed : Way::kCausal; }
};

/// Means over the series of a set.
struct Line {
  std::string name;
  std::size_t series = 0;
  double total = 0, heading = 0, inclination = 0, tilt_inside = 0, heading_inside = 0, tilt_nees = 0, heading_nees = 0;
  double ok_outside = 0;
  PeerScore peer;
  bool has_peer = false;

  void add(const Tally& t, const PeerScore* of_peer) {
    total += t.total_deg();
    heading += t.heading_deg();
    inclination += t.inclination_deg();
    tilt_inside += t.tilt_inside();
    heading_inside += t.heading_inside();
    tilt_nees += t.tilt_nees();
    heading_nees += t.heading_nees();
    ok_outside += t.ok_outside();
    if (of_peer != nullptr) {
      has_peer = true;
      peer = {peer.total + of_peer->total, peer.heading + of_peer->heading, peer.inclination + of_peer->inclination};
    }
    ++series;
  }
  [[nodiscard]] Line mean() const {
    Line m = *this;
    for (double* x : {&m.total, &m.heading, &m.inclination, &m.tilt_inside, &m.heading_inside, &m.tilt_nees,
                      &m.heading_nees, &m.ok_outside, &m.peer.total, &m.peer.heading, &m.peer.inclination})
      *x /= static_cast<double>(std::max<std::size_t>(series, 1));
    return m;
  }
};

void print_head() {
  fmt::print("{:<40} {:>3} {:>7} {:>7} {:>7}  {:>20} {:>7} {:>7} {:>6} {:>6} {:>8}\n", "degrees, mean of the RMSE", "n",
             "total", "heading", "tilt", "peer tot/head/tilt", "tilt in", "head in", "nees t", "nees h", "ok, out");
}

void print_line(const Line& l) {
  const std::string peer =
      l.has_peer ? fmt::format("{:.2f} {:.2f} {:.2f}", l.peer.total, l.peer.heading, l.peer.inclination) : "";
  fmt::print("{:<40} {:>3} {:7.2f} {:7.2f} {:7.2f}  {:>20} {:6.1f}% {:6.1f}% {:6.2f} {:6.2f} {:7.2f}%\n", l.name,
             l.series, l.total, l.heading, l.inclination, peer, 100 * l.tilt_inside, 100 * l.heading_inside,
             l.tilt_nees, l.heading_nees, 100 * l.ok_outside);
}

nlohmann::json json_of(const Line& l) {
  nlohmann::json out{{"set", l.name},
                     {"series", l.series},
                     {"total_deg", l.total},
                     {"heading_deg", l.heading},
                     {"inclination_deg", l.inclination},
                     {"tilt_inside", l.tilt_inside},
                     {"heading_inside", l.heading_inside},
                     {"tilt_nees", l.tilt_nees},
                     {"heading_nees", l.heading_nees},
                     {"ok_outside", l.ok_outside}};
  if (l.has_peer)
    out["peer"] = {
        {"total_deg", l.peer.total}, {"heading_deg", l.peer.heading}, {"inclination_deg", l.peer.inclination}};
  return out;
}

Line measure(const PortfolioSet& set, const pipeline::StagesParams& params, const PeerScores& peers,
             const Options& options) {
  Line sum;
  sum.name = set.name;
  for (const Series& series : set.series) {
    Tally tally;
    run_series(series, params, options.way(),
               [&](const Truth& truth, const pipeline::Processed& p) { tally.add(truth, p); });
    const auto peer = peers.find(set.peer_set + "," + series.name);
    const PeerScore* of_peer = peer != peers.end() ? &peer->second : nullptr;
    sum.add(tally, of_peer);
    if (!options.each) continue;
    Line one;
    one.name = series.name;
    one.add(tally, of_peer);
    print_line(one);
  }
  return sum.mean();
}

nlohmann::json gaps(const PortfolioSet& broad, const pipeline::StagesParams& params, const Options& options) {
  nlohmann::json out = nlohmann::json::array();
  for (const double gap_s : {0.05, 0.3, 2.0}) {
    const GapFigures g = gap_figures(broad, params, gap_s, options.way());
    if (!options.json)
      fmt::print(
          "gap of {:4.2f} s, {} of them on broad: total {:6.2f}, tilt {:6.2f} at once, tilt 5 s later {:5.2f}; inside "
          "{:5.1f}%, ok while outside {:5.2f}%\n",
          gap_s, g.gaps, g.total_then_deg, g.inclination_then_deg, g.inclination_after_deg, 100 * g.inside,
          100 * g.ok_outside);
    out.push_back({{"gap_s", gap_s},
                   {"gaps", g.gaps},
                   {"total_then_deg", g.total_then_deg},
                   {"inclination_then_deg", g.inclination_then_deg},
                   {"inclination_after_deg", g.inclination_after_deg},
                   {"inside", g.inside},
                   {"ok_outside", g.ok_outside}});
  }
  return out;
}

int run(const Options& options) {
  pipeline::StagesParams params;
  if (!options.config.empty()) {
    const auto config = io::read_config(options.config);
    if (!config) {
      fmt::print(stderr, "{}\n", config.error().message);
      return 78;
    }
    params = io::stages_params(*config);
  }
  const Wanted wanted = [&](const std::string& name) {
    return options.sets.empty() || std::find(options.sets.begin(), options.sets.end(), name) != options.sets.end();
  };
  PeerScores peers;  // of whole recordings
  if (options.begin_s == 0.0) peers = read_peer(options.recordings + "/vqf_per_recording.csv");
  std::vector<PortfolioSet> sets = recorded_sets(options.recordings, wanted, options.begin_s);
  if (sets.empty()) fmt::print(stderr, "{}: no recordings here; simulated sets only\n", options.recordings);
  for (auto& set : simulated_sets(options.seeds, wanted)) sets.push_back(std::move(set));
  nlohmann::json out{{"schema", "stillpoint.portfolio/1"}, {"sets", nlohmann::json::array()}};
  if (!options.json) print_head();
  for (const PortfolioSet& set : sets) {
    const Line line = measure(set, params, peers, options);
    out["sets"].push_back(json_of(line));
    if (!options.json) print_line(line);
  }
  for (const PortfolioSet& set : sets)
    if (set.name == "broad" && wanted("gaps")) out["gaps"] = gaps(set, params, options);
  if (options.json) fmt::print("{}\n", out.dump(1));
  return options.limits.empty() ? 0 : check_portfolio(out, options.limits, options.smooth ? "smoothed" : "causal");
}

}  // namespace
}  // namespace stillpoint::bench

int main(int argc, char** argv) {
  using namespace stillpoint::bench;
  Options options;
  CLI::App app{"The attitude over every kind of data at hand: errors and what was stated of them"};
  app.add_option("--recordings", options.recordings, "folder of the recordings")->capture_default_str();
  app.add_option("--config", options.config, "the daemon's configuration (.yaml); default: its defaults");
  app.add_option("--sets", options.sets, "names of sets, and gaps; default: all");
  app.add_option("--begin", options.begin_s, "leave out so many seconds of every recording: a start in the middle")
      ->check(CLI::NonNegativeNumber);
  app.add_option("--seeds", options.seeds, "of each simulated set")->capture_default_str();
  app.add_flag("--each", options.each, "a line for every series too");
  app.add_flag("--smooth", options.smooth, "forward and backward, as estimate --smooth");
  app.add_option("--check", options.limits, "fail where a figure is behind what FILE stores")->excludes("--begin");
  app.add_flag("--json", options.json, "on standard output, instead of the table");
  if (const auto end = parse(app, argc, argv)) return *end;
  return run(options);
}
