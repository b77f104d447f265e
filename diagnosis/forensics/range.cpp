/// Lattices (T7), rails (A10, G9, M12) and dead zones (T8) of single axes.
#include <algorithm>
#include <cmath>

#include "core/median.h"
#include "diagnosis/forensics/detail.h"

namespace stillpoint::diag::detail {
namespace {

constexpr std::size_t kLeastPile = 4;
constexpr double kPileOverNeighbours = 8.0;  // readings on the rail against those on the steps beside it
constexpr double kNoiseOverGrain = 5.0, kNoiseReaches = 3.0;
constexpr std::size_t kPileOverAnother = 2;
constexpr std::size_t kLeastRuns = 3;
constexpr std::size_t kLeastPeaks = 3;
constexpr double kAlike = 0.005, kNearRange = 0.03;  // what a factory calibration moves a rail by
constexpr double kApart = 4.0;                       // to the next lower reading, in the spread of the peaks
constexpr double kFarBelow = 0.75;
constexpr double kSameStep = 1e-3;  // relative; two blocks with the same lattice

struct Run {
  std::size_t first, last;  // rows, inclusive
};

std::vector<Run> runs_of(const std::vector<std::size_t>& rows) {
  std::vector<Run> runs;
  for (const std::size_t r : rows) {
    if (!runs.empty() && runs.back().last + 1 == r)
      runs.back().last = r;
    else
      runs.push_back({r, r});
  }
  return runs;
}

struct Pile {
  double value = 0.0;
  std::size_t readings = 0;
};

/// The value held by most readings, counted in steps of the file's decimals, among those between two (not included),
/// in the direction of `sign`.
Pile most_common(const Axis& axis, double sign, double above, double below) {
  std::vector<double> v;
  for (const double y : axis.y)
    if (sign * y > above && sign * y < below) v.push_back(sign * y);
  std::sort(v.begin(), v.end());
  Pile best;
  for (std::size_t i = 0, j = 0; i < v.size(); i = j) {
    for (j = i; j < v.size() && v[j] - v[i] <= 0.5 * axis.printed; ++j) {
    }
    if (j - i >= best.readings) best = {v[i], j - i};
  }
  return best;
}

/// From row to row, of half of them at least: its motion, too.
double noise_of(const Axis& axis) {
  constexpr double kMedianOfDifferences = 0.954;  // of normal ones
  std::vector<double> sizes;
  for (std::size_t i = 1; i < axis.y.size(); ++i)
    if (const double d = axis.y[i] - axis.y[i - 1]; std::isfinite(d)) sizes.push_back(std::abs(d));
  return sizes.empty() ? 0.0 : median(std::move(sizes)) / kMedianOfDifferences;
}

/// Whether `level` is a rail: a pile far above the counts beside it, nothing beyond while it lasts, and the readings
/// run into it and leave it steeply, several times. A body that lies still at its extreme reading does not do that.
std::optional<Rail> try_rail(const Axis& axis, double sign, double level) {
  const double grain = axis.grain();
  const double on = 0.51 * grain;
  Rail rail{.level = sign * level, .rows = {}};
  std::size_t beside = 0;
  for (std::size_t i = 0; i < axis.y.size(); ++i) {
    const double below = level - sign * axis.y[i];
    if (std::abs(below) <= on)
      rail.rows.push_back(i);
    else if (std::abs(below) <= 5.5 * grain)
      ++beside;
  }
  if (rail.rows.size() < kLeastPile) return std::nullopt;
  if (static_cast<double>(rail.rows.size()) < 3.0 + kPileOverNeighbours * static_cast<double>(beside) / 5.0)
    return std::nullopt;
  for (std::size_t i = rail.rows.front(); i <= rail.rows.back(); ++i)
    if (sign * axis.y[i] > level + on) return std::nullopt;
  const double steep = 5.0 * std::max(axis.noise_sd, grain);
  std::size_t steep_runs = 0;
  for (const Run& run : runs_of(rail.rows)) {
    if (run.first == 0 || run.last + 1 >= axis.y.size()) continue;
    steep_runs += level - sign * axis.y[run.first - 1] > steep && level - sign * axis.y[run.last + 1] > steep;
  }
  // Noise far above the steps does not come back to one number more than to the others within its reach, however slowly
  // the body turns there; a value that was held does not come back to it a third time.
  const double noise = std::min(axis.noise_sd, noise_of(axis));
  const auto below = [&] { return most_common(axis, sign, level - kNoiseReaches * noise, level - on).readings; };
  const bool noisy = noise > kNoiseOverGrain * grain && rail.rows.size() > kPileOverAnother * below();
  if (steep_runs < 2 && !(noisy && runs_of(rail.rows).size() >= kLeastRuns)) return std::nullopt;
  return rail;
}

}  // namespace

void examine_lattice(Axis& axis, std::size_t block_rows) {
  const std::span<const double> all(axis.y);
  axis.lattice = find_lattice(all, axis.printed);
  axis.lattice_first = 0, axis.lattice_last = axis.y.size();
  if (axis.lattice.step > 0) return;
  std::size_t run_first = 0, run_blocks = 0, best_first = 0, best_last = 0, best_blocks = 1;
  double run_step = 0.0;
  for (std::size_t b = 0; b + block_rows <= axis.y.size(); b += block_rows) {
    const double step = find_lattice(all.subspan(b, block_rows), axis.printed).step;
    const bool goes_on = step > 0 && run_blocks > 0 && std::abs(step - run_step) < kSameStep * run_step;
    if (!goes_on) run_first = b, run_blocks = 0;
    run_step = step;
    if (step > 0) ++run_blocks;
    if (run_blocks > best_blocks) best_blocks = run_blocks, best_first = run_first, best_last = b + block_rows;
  }
  if (best_blocks < 2) return;
  axis.lattice = find_lattice(all.subspan(best_first, best_last - best_first), axis.printed);
  axis.lattice_first = best_first, axis.lattice_last = best_last;
}

std::optional<Rail> find_rail(const Axis& axis, double sign) {
  double extreme = 0.0;
  for (const double y : axis.y) extreme = std::max(extreme, std::isfinite(y) ? sign * y : 0.0);
  if (!(extreme > 0)) return std::nullopt;
  if (auto rail = try_rail(axis, sign, extreme)) return rail;
  if (axis.lattice.step > 0) return std::nullopt;  // on a lattice every value is common
  // Where the limit held only for a while, larger readings stand elsewhere.
  const double common = most_common(axis, sign, extreme / 3.0, HUGE_VAL).value;
  return common > 0 ? try_rail(axis, sign, common) : std::nullopt;
}

std::optional<ClippedPeaks> find_clipped_peaks(std::span<const Axis> axes, std::span<const double> ranges) {
  struct Reading {
    double size;
    int axis;
    std::size_t row;
  };
  std::vector<Reading> top;
  for (std::size_t k = 0; k < axes.size(); ++k)
    for (std::size_t i = 1; i + 1 < axes[k].y.size(); ++i)
      if (std::isfinite(axes[k].y[i])) top.push_back({std::abs(axes[k].y[i]), static_cast<int>(k), i});
  if (top.size() < 1000) return std::nullopt;
  const auto more = [](const Reading& a, const Reading& b) { return a.size > b.size; };
  std::partial_sort(top.begin(), top.begin() + 12, top.end(), more);
  top.resize(12);
  std::size_t alike = 1;
  while (alike < top.size() && top[alike].size > (1.0 - kAlike) * top.front().size) ++alike;
  if (alike < kLeastPeaks || alike == top.size()) return std::nullopt;
  const double low = top[alike - 1].size, high = top.front().size, spread = std::max(high - low, 1e-3 * high);
  if (low - top[alike].size < kApart * spread) return std::nullopt;
  const double level = 0.5 * (low + high);
  if (std::none_of(ranges.begin(), ranges.end(),
                   [&](double range) { return std::abs(level - range) < kNearRange * range; }))
    return std::nullopt;
  ClippedPeaks peaks{level, low, high, {}};
  std::size_t axes_hit = 0;
  for (std::size_t i = 0; i < alike; ++i) {
    const Axis& a = axes[static_cast<std::size_t>(top[i].axis)];
    const double before = std::abs(a.y[top[i].row - 1]), after = std::abs(a.y[top[i].row + 1]);
    if (!(std::min(before, after) < kFarBelow * low)) return std::nullopt;
    axes_hit |= std::size_t{1} << static_cast<unsigned>(top[i].axis);
    peaks.rows.emplace_back(top[i].axis, top[i].row);
  }
  if ((axes_hit & (axes_hit - 1)) == 0) return std::nullopt;  // one axis alone may repeat its own shock
  return peaks;
}

std::optional<DeadZone> find_dead_zone(std::span<const Axis> axes) {
  DeadZone zone{.first = axes[0].y.size()};
  for (const Axis& a : axes) {
    for (std::size_t i = 0; i < a.y.size(); ++i) {
      if (a.y[i] != 0.0) continue;
      ++zone.zeros;
      zone.first = std::min(zone.first, i), zone.last = std::max(zone.last, i);
    }
  }
  if (zone.zeros < 8) return std::nullopt;
  double smallest = HUGE_VAL, grain = 0.0;
  for (const Axis& a : axes) {
    grain = std::max(grain, a.grain());
    for (std::size_t i = zone.first; i <= zone.last; ++i)
      if (a.y[i] != 0.0 && std::isfinite(a.y[i])) smallest = std::min(smallest, std::abs(a.y[i]));
  }
  std::size_t just_beyond = 0, off_lattice = 0;
  for (const Axis& a : axes)
    for (std::size_t i = zone.first; i <= zone.last; ++i) {
      const double size = std::abs(a.y[i]) / smallest;
      just_beyond += size >= 1.0 && size < 2.0;
      off_lattice += size > 1.02 && size < 1.98;
    }
  // The zero of a coarse lattice has empty gaps around it too, as wide as all the others.
  if (just_beyond == 0 || off_lattice < just_beyond / 4 || smallest < 2.5 * grain) return std::nullopt;
  // Beyond the zone the readings have some density; the first of them lies an exponential distance outside.
  const double spacing = smallest / static_cast<double>(just_beyond);
  zone.width = std::max(smallest - 0.69 * spacing, 0.0);
  zone.ci95 = {std::max(smallest - 3.69 * spacing, 0.0), smallest - 0.025 * spacing};
  return zone;
}

}  // namespace stillpoint::diag::detail
