/// The sets of the portfolio: recordings with an optical reference, and simulated sensors with the truth.
#pragma once
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "bench/portfolio_run.h"

namespace stillpoint::bench {

/// VQF's errors in degrees on the same rows, by "set,recording".
struct PeerScore {
  double total = 0.0, heading = 0.0, inclination = 0.0;
};
using PeerScores = std::map<std::string, PeerScore>;
[[nodiscard]] PeerScores read_peer(const std::string& csv_path);

struct PortfolioSet {
  std::string name;
  std::string peer_set;        ///< first column of the peer's table; empty: not measured
  double scored_from_s = 0.0;  ///< errors count from here on
  std::vector<Series> series;
};

/// Those of the folder ../shared/recordings that are there; `wanted` is asked for each set's name before it is read.
/// Rows of the first `begin_s` are left out: a start in the middle.
using Wanted = std::function<bool(const std::string&)>;
[[nodiscard]] std::vector<PortfolioSet> recorded_sets(const std::string& folder, const Wanted& wanted,
                                                      double begin_s = 0.0);
[[nodiscard]] std::vector<PortfolioSet> simulated_sets(unsigned seeds, const Wanted& wanted);

/// A consumer sensor in a hand for 150 s; `truths[k]` belongs to `rows[k]`.
[[nodiscard]] Series hand_series(unsigned seed);

/// Ten gaps cut out of each trial, each where the body turns fastest in its tenth of the trial.
struct GapFigures {
  double inclination_then_deg = 0.0, total_then_deg = 0.0;  ///< mean at the first sample after the gap
  double inclination_after_deg = 0.0;                       ///< mean 5 s later
  double inside = 0.0;                                      ///< share of the 5 s after, tilt and heading inside 3 sigma
  double ok_outside = 0.0;
  std::size_t gaps = 0;
};
[[nodiscard]] GapFigures gap_figures(const PortfolioSet& broad, const pipeline::StagesParams& params, double gap_s,
                                     Way way);

}  // namespace stillpoint::bench
