/// Percentiles of each cell, their medians over the repeats, ratios to the floors, and the ways to show and to judge
/// them.
#pragma once
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bench/latency_channels.h"

namespace stillpoint::bench {

inline constexpr std::array kQuantiles{0.50, 0.90, 0.99, 0.999, 1.0};
inline constexpr std::array kQuantileNames{"p50", "p90", "p99", "p99.9", "max"};

/// One repeat of one channel at one rate.
struct Cell {
  std::array<double, kQuantiles.size()> latency_us{};
  std::size_t received = 0;
  std::uint64_t lost = 0;  ///< gaps in the sequence after the first message that arrived
};

/// Leaves the first quarter out: matching, caches and the clock's ramp-up are not what is asked for.
[[nodiscard]] Cell make_cell(std::vector<Receipt> receipts);

/// All repeats of one channel at one rate.
struct Series {
  std::string channel;
  double rate_hz = 0.0;
  std::vector<Cell> repeats;
  std::vector<double> sorted_us;  ///< all repeats together, for the figure
};

/// One channel over another, repeat by repeat, then the median: what the machine did during a repeat cancels.
struct Ratio {
  std::string channel, over;
  double rate_hz = 0.0;
  std::array<double, kQuantiles.size()> median{};
};

struct Machine {
  std::string cpu, kernel, scheduling;
  int cores = 0;
  double load_before = 0.0, load_after = 0.0;
  double steal_share = 0.0;  ///< of the processor time during the run
};

struct LatencyReport {
  Machine machine;
  std::vector<Series> series;
  [[nodiscard]] std::vector<Ratio> ratios() const;
};

[[nodiscard]] double median(std::vector<double> values);
[[nodiscard]] std::string text(const LatencyReport& report);
[[nodiscard]] nlohmann::json json(const LatencyReport& report);
/// Latency over percentile, both logarithmic towards the tail, one panel a rate (the form of HdrHistogram's plots).
[[nodiscard]] std::string svg(const LatencyReport& report);
/// What exceeds the limits (bench/latency_limits.json), in words; a limit whose channels were not measured is named
/// too.
[[nodiscard]] std::vector<std::string> regressions(const LatencyReport& report, const nlohmann::json& limits);

}  // namespace stillpoint::bench
