#include "bench/latency_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace stillpoint::bench {
namespace {

/// The sample below which the share q lies (nearest rank).
double quantile(const std::vector<double>& sorted, double q) {
  if (sorted.empty()) return std::nan("");
  const auto rank = static_cast<std::size_t>(std::ceil(q * static_cast<double>(sorted.size())));
  return sorted[std::clamp<std::size_t>(rank, 1, sorted.size()) - 1];
}

std::array<double, kQuantiles.size()> medians(const Series& series) {
  std::array<double, kQuantiles.size()> out{};
  for (std::size_t q = 0; q < out.size(); ++q) {
    std::vector<double> values;
    for (const Cell& cell : series.repeats) values.push_back(cell.latency_us[q]);
    out[q] = median(values);
  }
  return out;
}

const Series* find(const LatencyReport& report, const std::string& channel, double rate_hz) {
  for (const Series& s : report.series)
    if (s.channel == channel && s.rate_hz == rate_hz) return &s;
  return nullptr;
}

std::uint64_t lost(const Series& series) {
  std::uint64_t sum = 0;
  for (const Cell& cell : series.repeats) sum += cell.lost;
  return sum;
}

}  // namespace

double median(std::vector<double> values) {
  if (values.empty()) return std::nan("");
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : 0.5 * (values[half - 1] + values[half]);
}

Cell make_cell(std::vector<Receipt> receipts) {
  receipts.erase(receipts.begin(), receipts.begin() + static_cast<std::ptrdiff_t>(receipts.size() / 4));
  Cell cell;
  cell.received = receipts.size();
  if (receipts.empty()) return cell;
  cell.lost = receipts.back().sequence - receipts.front().sequence + 1 - receipts.size();
  std::vector<double> us;
  for (const Receipt& r : receipts) us.push_back(1e-3 * static_cast<double>(r.latency_ns));
  std::sort(us.begin(), us.end());
  for (std::size_t q = 0; q < kQuantiles.size(); ++q) cell.latency_us[q] = quantile(us, kQuantiles[q]);
  return cell;
}

std::vector<Ratio> LatencyReport::ratios() const {
  std::vector<Ratio> out;
  for (const Series& s : series) {
    std::vector<std::string> floors{"shm_futex"};
    if (s.channel.starts_with("daemon/")) floors.push_back("fastdds" + s.channel.substr(s.channel.find('/')));
    for (const std::string& floor : floors) {
      const Series* below = find(*this, floor, s.rate_hz);
      if (below == nullptr || floor == s.channel) continue;
      Ratio ratio{.channel = s.channel, .over = floor, .rate_hz = s.rate_hz, .median = {}};
      for (std::size_t q = 0; q < kQuantiles.size(); ++q) {
        std::vector<double> values;
        for (std::size_t i = 0; i < std::min(s.repeats.size(), below->repeats.size()); ++i)
          values.push_back(s.repeats[i].latency_us[q] / below->repeats[i].latency_us[q]);
        ratio.median[q] = median(values);
      }
      out.push_back(ratio);
    }
  }
  return out;
}

std::string text(const LatencyReport& report) {
  const Machine& m = report.machine;
  std::string out = fmt::format("{}, {} cores, Linux {}; {}; load {:.2f} before, {:.2f} after, steal {:.1f} %\n", m.cpu,
                                m.cores, m.kernel, m.scheduling, m.load_before, m.load_after, 100 * m.steal_share);
  out += "Instant a sample was due to the callback in another process; us; median of the repeats.\n";
  out += fmt::format("{:>6}  {:<22}{:>9}{:>9}{:>9}{:>9}{:>9}{:>7}{:>9}\n", "Hz", "channel", "p50", "p90", "p99",
                     "p99.9", "max", "lost", "repeats");
  for (const Series& s : report.series) {
    const auto q = medians(s);
    out += fmt::format("{:>6.0f}  {:<22}{:>9.1f}{:>9.1f}{:>9.1f}{:>9.1f}{:>9.1f}{:>7}{:>9}\n", s.rate_hz, s.channel,
                       q[0], q[1], q[2], q[3], q[4], lost(s), s.repeats.size());
  }
  out += "Ratios inside one repeat, median over the repeats:\n";
  for (const Ratio& r : report.ratios())
    out += fmt::format("{:>6.0f}  {:<22} over {:<22} p50 {:5.2f}  p99 {:5.2f}\n", r.rate_hz, r.channel, r.over,
                       r.median[0], r.median[2]);
  return out;
}

nlohmann::json json(const LatencyReport& report) {
  const Machine& m = report.machine;
  nlohmann::json out{{"schema", "stillpoint.latency/1"},
                     {"machine",
                      {{"cpu", m.cpu},
                       {"cores", m.cores},
                       {"kernel", m.kernel},
                       {"scheduling", m.scheduling},
                       {"load_before", m.load_before},
                       {"load_after", m.load_after},
                       {"steal_share", m.steal_share}}},
                     {"series", nlohmann::json::array()},
                     {"ratios", nlohmann::json::array()}};
  for (const Series& s : report.series) {
    nlohmann::json entry{{"channel", s.channel}, {"rate_hz", s.rate_hz}, {"lost", lost(s)}};
    const auto values = medians(s);
    for (std::size_t q = 0; q < kQuantiles.size(); ++q) entry["median_us"][kQuantileNames[q]] = values[q];
    for (const Cell& cell : s.repeats)
      entry["repeats"].push_back({{"received", cell.received}, {"lost", cell.lost}, {"latency_us", cell.latency_us}});
    out["series"].push_back(entry);
  }
  for (const Ratio& r : report.ratios()) {
    nlohmann::json entry{{"channel", r.channel}, {"over", r.over}, {"rate_hz", r.rate_hz}};
    for (std::size_t q = 0; q < kQuantiles.size(); ++q) entry[kQuantileNames[q]] = r.median[q];
    out["ratios"].push_back(entry);
  }
  return out;
}

std::vector<std::string> regressions(const LatencyReport& report, const nlohmann::json& limits) {
  std::vector<std::string> out;
  const std::vector<Ratio> ratios = report.ratios();
  for (const auto& limit : limits.at("limits")) {
    const std::string channel = limit.at("channel"), over = limit.at("over");
    const double rate_hz = limit.at("rate_hz");
    const auto it = std::find_if(ratios.begin(), ratios.end(), [&](const Ratio& r) {
      return r.channel == channel && r.over == over && r.rate_hz == rate_hz;
    });
    if (it == ratios.end()) {
      out.push_back(fmt::format("{} over {} at {:.0f} Hz has a limit and was not measured", channel, over, rate_hz));
      continue;
    }
    for (std::size_t q = 0; q < kQuantiles.size(); ++q) {
      if (!limit.contains(kQuantileNames[q])) continue;
      const double most = limit.at(kQuantileNames[q]);
      if (!(it->median[q] <= most))
        out.push_back(fmt::format("{} over {} at {:.0f} Hz: {} ratio {:.2f}, limit {:.2f}", channel, over, rate_hz,
                                  kQuantileNames[q], it->median[q], most));
    }
  }
  return out;
}

}  // namespace stillpoint::bench
