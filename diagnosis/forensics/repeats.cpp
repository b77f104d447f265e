/// Exact repeats: rows duplicated in every sensor (T5) and a triad that is slower than its rows (M9).
#include <algorithm>
#include <cmath>

#include "diagnosis/forensics/detail.h"

namespace stillpoint::diag::detail {
namespace {

constexpr std::size_t kRepeatRows = 100;
constexpr std::size_t kChanceRows = 1000;  // enough to know how often a triad repeats by itself
constexpr double kRegularShare = 0.9;      // of the runs have one of two neighbouring lengths
constexpr double kLeastHoldShare = 0.25;   // of a block's rows are stale where a triad is held
constexpr double kInterpolatedShare = 0.9;

bool measured(std::span<const Axis> axes, std::size_t row) {
  return std::all_of(axes.begin(), axes.end(), [row](const Axis& a) { return std::isfinite(a.y[row]); });
}

bool repeats(std::span<const Axis> axes, std::size_t row) {
  return std::all_of(axes.begin(), axes.end(), [row](const Axis& a) { return a.y[row] == a.y[row - 1]; });
}

/// Marks the rows of a file resampled to twice its rate by straight lines: in each block, those of the parity whose
/// rows are the mean of their neighbours. A lost row flips the parity, so each block finds its own. Empty: not
/// resampled.
std::vector<std::uint8_t> find_midpoints(std::span<const Axis> axes) {
  const std::size_t rows = axes[0].y.size();
  std::vector<std::uint8_t> marked(rows, 0);
  std::size_t midpoints = 0, differing = 0;
  for (std::size_t b = 1; b + 1 < rows; b += kRepeatRows) {
    std::array<std::size_t, 2> moved_rows{}, midpoint_rows{};
    for (std::size_t i = b; i < std::min(b + kRepeatRows, rows - 1); ++i) {
      if (!measured(axes, i) || !measured(axes, i - 1) || !measured(axes, i + 1)) continue;
      bool moved = false, midpoint = true;
      for (const Axis& a : axes) {
        moved = moved || std::abs(a.y[i + 1] - a.y[i - 1]) > 3.0 * a.printed;
        midpoint = midpoint && std::abs(a.y[i] - 0.5 * (a.y[i - 1] + a.y[i + 1])) <= 0.6 * a.printed + 1e-12;
      }
      moved_rows[i % 2] += moved;
      midpoint_rows[i % 2] += moved && midpoint;
    }
    const std::size_t parity = midpoint_rows[1] > midpoint_rows[0] ? 1 : 0;
    midpoints += midpoint_rows[parity], differing += moved_rows[parity];
    for (std::size_t i = b; i < std::min(b + kRepeatRows, rows); ++i) marked[i] = i % 2 == parity;
  }
  if (differing < 20 || static_cast<double>(midpoints) < kInterpolatedShare * static_cast<double>(differing)) return {};
  return marked;
}

/// Share of `lengths` that equal the whole numbers around their mean.
double two_length_share(const std::vector<std::size_t>& lengths) {
  double mean = 0.0;
  for (const auto n : lengths) mean += static_cast<double>(n) / static_cast<double>(lengths.size());
  const auto near = std::count_if(lengths.begin(), lengths.end(), [mean](std::size_t n) {
    return static_cast<double>(n) > mean - 1.001 && static_cast<double>(n) < mean + 1.001;
  });
  return static_cast<double>(near) / static_cast<double>(lengths.size());
}

std::vector<std::size_t> differences(const std::vector<std::size_t>& rows) {
  std::vector<std::size_t> d;
  for (std::size_t i = 0; i + 1 < rows.size(); ++i) d.push_back(rows[i + 1] - rows[i]);
  return d;
}

/// Narrows [first, last) to the blocks in which stale rows are common, from the first reading that is held in them to
/// the last.
void narrow(const std::vector<std::uint8_t>& stale, std::size_t& first, std::size_t& last) {
  std::size_t begin = stale.size(), end = 0;
  for (std::size_t b = 0; b < stale.size(); b += kRepeatRows) {
    const std::size_t e = std::min(b + kRepeatRows, stale.size());
    const auto n = std::count(stale.begin() + static_cast<long>(b), stale.begin() + static_cast<long>(e), 1);
    if (static_cast<double>(n) < kLeastHoldShare * static_cast<double>(e - b)) continue;
    begin = std::min(begin, b);
    end = e;
  }
  while (begin < end && !stale[begin]) ++begin;
  while (end > begin && !stale[end - 1]) --end;
  first = begin > 0 ? begin - 1 : begin, last = std::max(first, end);
}

}  // namespace

std::vector<std::uint8_t> find_duplicates(std::span<const Axis> axes) {
  const std::size_t rows = axes.empty() ? 0 : axes[0].y.size();
  std::vector<std::uint8_t> duplicate(rows, 0);
  double by_chance = 0.0;
  std::size_t found = 0;
  for (std::size_t b = 1; b < rows; b += kChanceRows) {
    const std::size_t e = std::min(b + kChanceRows, rows);
    std::size_t here = 0;
    for (std::size_t i = b; i < e; ++i)
      if (measured(axes, i) && repeats(axes, i)) duplicate[i] = 1, ++here;
    // The axes of a triad repeat together where the triad is held, so a triad counts as one. The rows that repeat
    // everywhere are left out of each triad's own rate: otherwise they would excuse themselves.
    double chance = static_cast<double>(e - b);
    for (std::size_t s = 0; s < axes.size(); s += 3) {
      std::size_t same = 0;
      for (std::size_t i = b; i < e; ++i) same += duplicate[i] == 0 && repeats(axes.subspan(s, 3), i);
      chance *= static_cast<double>(same) / static_cast<double>(std::max<std::size_t>(e - b - here, 1));
    }
    by_chance += chance;
    found += here;
  }
  if (found < 3 || static_cast<double>(found) < 3.0 + 5.0 * by_chance) return {};
  return duplicate;
}

std::optional<Hold> find_hold(std::span<const Axis> axes, const std::vector<std::uint8_t>& ignore) {
  Hold hold;
  const auto midpoint = find_midpoints(axes);
  hold.interpolated = !midpoint.empty();
  std::vector<std::size_t> rows;  // the rows to look at: measured, not duplicated everywhere, not interpolated
  for (std::size_t i = 0; i < axes[0].y.size(); ++i)
    if (measured(axes, i) && (ignore.empty() || ignore[i] == 0) && (midpoint.empty() || midpoint[i] == 0))
      rows.push_back(i);
  if (rows.size() < 2 * kRepeatRows) return std::nullopt;

  std::vector<std::uint8_t> stale(rows.size(), 0);
  for (std::size_t j = 1; j < rows.size(); ++j)
    stale[j] = std::all_of(axes.begin(), axes.end(), [&](const Axis& a) { return a.y[rows[j]] == a.y[rows[j - 1]]; });
  std::size_t first = 0, last = 0;
  narrow(stale, first, last);
  if (last <= first + kRepeatRows / 2) return std::nullopt;
  std::vector<std::size_t> fresh_at, stale_at;
  for (std::size_t j = first; j < last; ++j) (stale[j] ? stale_at : fresh_at).push_back(j);
  if (fresh_at.size() < 10 || stale_at.size() < 10) return std::nullopt;
  // A fixed period n gives runs of one or two lengths; below n = 2 it is the distance of the repeats that is regular.
  hold.regular = two_length_share(differences(fresh_at)) > kRegularShare &&
                 (stale_at.size() > fresh_at.size() || two_length_share(differences(stale_at)) > kRegularShare);
  if (!hold.regular) return std::nullopt;
  hold.period_rows =
      static_cast<double>(last - first) / static_cast<double>(fresh_at.size()) * (hold.interpolated ? 2 : 1);
  hold.first = rows[first], hold.last = rows[last - 1];
  hold.stale.assign(axes[0].y.size(), hold.interpolated ? 1 : 0);
  for (std::size_t j = 0; j < rows.size(); ++j) hold.stale[rows[j]] = j >= first && j < last ? stale[j] : 0;
  return hold;
}

}  // namespace stillpoint::diag::detail
