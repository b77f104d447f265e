#include "diagnosis/no_reference/noisy_rail.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "core/median.h"
#include "diagnosis/forensics/forensics.h"
#include "diagnosis/no_reference/model.h"

namespace stillpoint::diag::detail {
namespace {

constexpr std::size_t kQuiet = 16;  // rows in which the noise is measured
constexpr double kBand = 4.0;       // in deviations of the noise, as all below
constexpr double kSteep = 8.0;      // from the last reading before the rail, and to the first after it
constexpr double kFlat = 60.0;      // steepness times rows: a round top of the same height has 32
constexpr std::size_t kLeastRows = 4, kLeastRuns = 3;
constexpr std::array<double, 2> kLeastRange{11.0, 0.27};  // m/s^2: no rest reads more; rad/s: no part is sold with less

/// Of white noise, from second differences where they are smallest.
double noise_of(const std::vector<double>& y) {
  std::vector<double> sd;
  for (std::size_t i = 0; i + kQuiet + 2 <= y.size(); i += kQuiet) {
    double sum = 0.0;
    for (std::size_t k = i; k < i + kQuiet; ++k) sum += std::pow(y[k] - 2.0 * y[k + 1] + y[k + 2], 2);
    if (std::isfinite(sum)) sd.push_back(std::sqrt(sum / (6.0 * kQuiet)));
  }
  return quantile(sd, 0.1);
}

struct NoisyRail {
  double level = 0.0, deviation = 0.0;
  std::size_t runs = 0, rows = 0, first = 0, last = 0;
};

/// Upward; `y` may be turned round.
std::optional<NoisyRail> rail_above(const std::vector<double>& y, double noise) {
  double highest = -HUGE_VAL;
  for (const double v : y)
    if (std::isfinite(v)) highest = std::max(highest, v);
  std::vector<double> top;
  for (const double v : y)
    if (v > highest - 2.0 * kBand * noise) top.push_back(v);
  NoisyRail rail{.level = median(top), .first = y.size()};
  const auto on_it = [&](std::size_t i) { return std::abs(y[i] - rail.level) <= kBand * noise; };
  double sum = 0.0;
  for (std::size_t i = 1; i < y.size(); ++i) {
    if (!on_it(i) || on_it(i - 1)) continue;
    std::size_t end = i;
    while (end < y.size() && on_it(end)) ++end;
    if (end == y.size() || end - i < kLeastRows) continue;
    const double rise = rail.level - y[i - 1], fall = rail.level - y[end];
    const auto rows = static_cast<double>(end - i);
    if (!(std::min(rise, fall) > kSteep * noise) || 0.5 * (rise + fall) * rows < kFlat * noise) continue;
    ++rail.runs, rail.rows += end - i;
    rail.first = std::min(rail.first, i), rail.last = end - 1;
    for (std::size_t k = i; k < end; ++k) sum += y[k];
  }
  if (rail.runs < kLeastRuns || 2 * rail.rows < top.size()) return std::nullopt;
  rail.level = sum / static_cast<double>(rail.rows);
  rail.deviation = noise / std::sqrt(static_cast<double>(rail.rows));
  return rail;
}

}  // namespace

std::vector<Finding> find_noisy_rails(const io::Recording& r, const sim::SimulationConfig& simulation) {
  std::vector<Finding> out;
  for (const Sensor s : {kAcc, kGyr}) {
    const auto* simulated = triad(simulation, s);
    if (simulated == nullptr) continue;
    Finding f;
    std::size_t runs = 0, rows = 0, first = r.size(), last = 0;
    for (int k = 0; k < 3; ++k)
      for (const double sign : {1.0, -1.0}) {
        std::vector<double> y;
        for (const Vec3& v : triad(r, s)) y.push_back(sign * corrected(*simulated, v)[k]);
        const double noise = noise_of(y);
        const auto rail = noise > 0.0 ? rail_above(y, noise) : std::nullopt;
        if (!rail || std::abs(rail->level) < kLeastRange[s]) continue;
        const double half = 1.96 * rail->deviation, level = sign * rail->level;
        f.parameters.push_back({fmt::format("level_{}{}", "xyz"[k], sign > 0 ? "+" : "-"),
                                level,
                                {level - half, level + half},
                                kSensorUnit[s]});
        if (const auto channel = fmt::format("{}_{}", kSensorName[s], "xyz"[k]);
            f.channels.empty() || f.channels.back() != channel)
          f.channels.push_back(channel);
        runs += rail->runs, rows += rail->rows;
        first = std::min(first, rail->first), last = std::max(last, rail->last);
      }
    if (f.channels.empty()) continue;
    f.effect = fmt::format("{}_sat", kSensorName[s]);
    f.interval_s = {r.t_s(first), r.t_s(last)};
    f.equation = "y = clip(y, +-level)";
    f.driver = "the reading itself";
    f.regime = fmt::format("only at the limit: {} excursions, {} readings, end flat at one level and leave it steeply",
                           runs, rows);
    f.decided_by = "a larger range setting removes it";
    out.push_back(std::move(f));
  }
  return out;
}

}  // namespace stillpoint::diag::detail
