/// Rails, clipped peaks and dead zones as findings.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/units.h"
#include "diagnosis/forensics/examination.h"

namespace stillpoint::diag::detail {
namespace {

/// Half of the smallest range that parts are sold with (1 g, 31 degrees a second, 60 uT): a lattice near the noise
/// piles readings up at its few values too, at rest.
constexpr std::array<double, 3> kLeastRange{4.9, 0.27, 30.0};

std::vector<double> scaled(std::vector<double> values, double unit) {
  for (double& v : values) v *= unit;
  return values;
}

/// Whether readings of this sign are larger: what limits those of the other one does not limit them.
bool reaches_beyond(const Axis& axis, double level) {
  const double least = std::abs(level) + axis.grain(), sign = std::copysign(1.0, level);
  return std::any_of(axis.y.begin(), axis.y.end(), [&](double y) { return sign * y > least; });
}

}  // namespace

void Examination::examine_rails(Sensor s) {
  std::vector<Parameter> levels;
  std::vector<std::string> channels;
  std::size_t spoiled = 0, first = recording_.size(), last = 0;
  double low = HUGE_VAL, high = 0.0, grain = 0.0;
  std::vector<Parameter> sides;
  for (int i = 0; i < 3; ++i) {
    const Axis& a = axes_[s][static_cast<std::size_t>(i)];
    const std::size_t before = levels.size();
    for (const double sign : {1.0, -1.0}) {
      const auto rail = find_rail(a, sign);
      if (!rail || std::abs(rail->level) < kLeastRange[static_cast<std::size_t>(s)]) continue;
      for (const std::size_t r : rail->rows) mute(s, r);
      spoiled += rail->rows.size();
      first = std::min(first, rail->rows.front()), last = std::max(last, rail->rows.back());
      low = std::min(low, std::abs(rail->level)), high = std::max(high, std::abs(rail->level));
      grain = std::max(grain, a.grain());
      const double half = 0.5 * a.grain();
      levels.push_back({fmt::format("level_{}{}", "xyz"[i], sign > 0 ? "+" : "-"),
                        rail->level,
                        {rail->level - half, rail->level + half},
                        kSensorUnit[s]});
      if (channels.empty() || channels.back() != channel(s, i)) channels.push_back(channel(s, i));
    }
    if (levels.size() == before + 1) {
      const double side = reaches_beyond(a, -levels.back().value) ? std::copysign(1.0, levels.back().value) : 0.0;
      sides.push_back({fmt::format("side_{}", "xyz"[i]), side, {side, side}, "1"});
    }
  }
  if (levels.empty()) return;
  out_.sensor[s].saturated = true;
  if (high - low <= 1.01 * grain)
    levels = {{"level", 0.5 * (low + high), {low - 0.5 * grain, high + 0.5 * grain}, kSensorUnit[s]}};
  if (std::any_of(sides.begin(), sides.end(), [](const Parameter& side) { return side.value != 0.0; }))
    levels.insert(levels.end(), sides.begin(), sides.end());
  Finding f = make(fmt::format("{}_sat", kSensorName[s]), std::move(channels), first, last);
  f.parameters = std::move(levels);
  f.equation = "y = clip(y, +-level)";
  f.driver = "the reading itself";
  f.regime = fmt::format("only at the limit: {} readings lie on it, run into it and leave it steeply", spoiled);
  f.decided_by = "already decided: readings pile up at one value; a larger range setting removes it";
  state(std::move(f), spoiled);
}

void Examination::examine_peaks(Sensor s) {
  static const std::vector<double> none,
      acc_mps2 = scaled({2, 4, 6, 8, 12, 16, 20, 24, 32, 40, 64, 100, 200, 400}, kStandardGravity_mps2),
      gyr_radps = scaled({125, 250, 450, 500, 1000, 2000, 4000}, kRadPerDeg);
  const auto peaks = find_clipped_peaks(axes_[s], s == kAcc ? acc_mps2 : s == kGyr ? gyr_radps : none);
  if (!peaks) return;
  std::array<bool, 3> hit{};
  std::size_t first = recording_.size(), last = 0;
  for (const auto& [axis, row] : peaks->rows) {
    mute(s, row);
    hit[static_cast<std::size_t>(axis)] = true;
    first = std::min(first, row), last = std::max(last, row);
  }
  std::vector<std::string> channels;
  for (int i = 0; i < 3; ++i)
    if (hit[static_cast<std::size_t>(i)]) channels.push_back(channel(s, i));
  out_.sensor[s].saturated = true;
  Finding f = make(fmt::format("{}_sat", kSensorName[s]), std::move(channels), first, last);
  f.parameters = {{"level", peaks->level, {peaks->low, peaks->high}, kSensorUnit[s]}};
  f.equation = "y = clip(y, +-level)";
  f.driver = "the reading itself";
  f.regime = fmt::format(
      "shocks only: the {} highest readings, of several axes, agree to {:.2f} % and lie at a customary range, "
      "although "
      "nothing piles up at one number: a calibration after the rail pulls them apart",
      peaks->rows.size(), 100.0 * (peaks->high - peaks->low) / peaks->level);
  f.decided_by = "the readings before the factory calibration, or a larger range setting";
  state(std::move(f), peaks->rows.size());
}

void Examination::examine_dead_zone() {
  const auto zone = find_dead_zone(axes_[kGyr]);
  if (!zone) return;
  std::vector<std::string> channels;
  for (int i = 0; i < 3; ++i) {
    const auto& y = axes_[kGyr][static_cast<std::size_t>(i)].y;
    bool any = false;
    for (std::size_t r = zone->first; r <= zone->last; ++r)
      if (y[r] == 0.0) mute(kGyr, r), any = true;
    if (any) channels.push_back(channel(kGyr, i));
  }
  Finding f = make("gyr_deadzone", std::move(channels), zone->first, zone->last);
  f.parameters = {{"d", zone->width, zone->ci95, "rad/s"}};
  f.equation = "y = 0 where |y| < d";
  f.driver = "the reading itself";
  f.regime = fmt::format("slow turns and rest: {} readings are exactly 0 and none lies between 0 and d", zone->zeros);
  f.decided_by = "already decided: exact zeros with an empty gap around them";
  state(std::move(f), zone->zeros);
}

}  // namespace stillpoint::diag::detail
