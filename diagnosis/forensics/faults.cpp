#include "diagnosis/forensics/faults.h"
#include "core/median.h"

#include <algorithm>
#include <cmath>

namespace stillpoint::diag::detail {
namespace {

constexpr std::size_t kFewestFlips = 5, kRepeatBlock = 64, kLongestRun = 4;
constexpr double kFewestRepeats = 10.0;
constexpr double kPairsToCompare = 5.0;   // expected
constexpr double kBeyondChance = 8.0;     // axes at rest do not repeat quite independently
constexpr double kFarOff = 12.0;          // robust deviations of a single reading from its neighbours
constexpr std::size_t kBlockRows = 256;   // over which the scatter of readings is taken
constexpr double kFlipShare = 0.8;        // of the single readings far off that are a power of two off
constexpr double kLeastFlip_steps = 8.0;  // smaller powers of two lie too close together to tell
constexpr double kExpectedReadings = 40.0;
constexpr int kMostBits = 6;
constexpr long long kMostCodes = 1 << 22;

bool measured(const Axis& a, std::size_t row) { return std::isfinite(a.y[row]); }

/// Reading minus the cubic through two neighbours on either side; not finite where one is missing.
double off_neighbours(const std::vector<double>& y, std::size_t i) {
  return y[i] - (4.0 * (y[i - 1] + y[i + 1]) - y[i - 2] - y[i + 2]) / 6.0;
}

struct Spike {
  std::size_t row = 0;
  double size = 0.0, scale = 0.0;
};

/// Single readings far off both neighbours while the neighbours agree with each other.
std::vector<Spike> spikes_of(const Axis& a) {
  std::vector<Spike> out;
  const std::size_t n = a.y.size();
  for (std::size_t b = 2; b + 2 < n; b += kBlockRows) {
    const std::size_t e = std::min(b + kBlockRows, n - 2);
    std::vector<double> off, size;
    for (std::size_t i = b; i < e; ++i) off.push_back(off_neighbours(a.y, i));
    for (const double x : off)
      if (std::isfinite(x)) size.push_back(std::abs(x));
    const double scale = std::max({1.4826 * median(size), 0.3 * a.grain(), a.noise_sd});
    for (std::size_t i = b; i < e; ++i) {
      const double x = off[i - b];
      const double beside = std::abs(a.y[i + 1] - a.y[i - 1]);
      if (std::abs(x) > kFarOff * scale && beside < 0.25 * std::abs(x)) out.push_back({i, x, scale});
    }
  }
  // Two rows off, the cubic still feels a sixth of a peak.
  const auto echoes = [all = out](const Spike& s) {
    return std::any_of(all.begin(), all.end(), [&s](const Spike& o) {
      return o.row != s.row && o.row + 2 >= s.row && s.row + 2 >= o.row && std::abs(o.size) > std::abs(s.size);
    });
  };
  std::erase_if(out, echoes);
  return out;
}

/// Residues of the codes, counted from the lowest, that no reading has.
std::vector<bool> absent_residues(const std::vector<double>& count, std::size_t modulus) {
  std::vector<bool> absent(modulus, true);
  for (std::size_t c = 0; c < count.size(); ++c)
    if (count[c] > 0) absent[c % modulus] = false;
  return absent;
}

/// Every second, every fourth code alone: a lattice with a wider step, and no code is missing from it.
bool is_coarser_lattice(const std::vector<bool>& absent) {
  for (std::size_t step = 2; step < absent.size(); step *= 2)
    for (std::size_t first = 0; first < step; ++first) {
      bool alike = true;
      for (std::size_t r = 0; r < absent.size(); ++r) alike = alike && absent[r] == (r % step != first);
      if (alike) return true;
    }
  return false;
}

/// Readings that the absent codes would have were they as frequent as the rarer of the codes on either side.
double readings_due(const std::vector<double>& count, const std::vector<bool>& absent) {
  const std::size_t modulus = absent.size();
  double due = 0.0;
  for (std::size_t c = 1; c + 1 < count.size(); ++c) {
    if (!absent[c % modulus]) continue;
    std::size_t below = c - 1, above = c + 1;
    while (below > 0 && absent[below % modulus]) --below;
    while (above + 1 < count.size() && absent[above % modulus]) ++above;
    due += std::min(count[below], count[above]);
  }
  return due;
}

/// Whether the readings before a row and after it change by so many steps that one that repeats is no accident of its
/// lattice.
bool changes_around(std::span<const Axis> axes, std::size_t row) {
  constexpr double kSteps = 3.0;
  return std::any_of(axes.begin(), axes.end(), [row](const Axis& a) {
    const auto changes = [&](std::size_t from) {
      return std::abs(a.y[from + 1] - a.y[from]) + std::abs(a.y[from + 2] - a.y[from + 1]) > 2.0 * kSteps * a.grain();
    };
    return row >= 3 && row + 2 < a.y.size() && changes(row - 3) && changes(row);
  });
}

}  // namespace

std::vector<std::size_t> find_random_repeats(std::span<const Axis> axes, const std::vector<std::uint8_t>& ignore) {
  std::vector<std::size_t> rows;
  double chance = 0.0, pairs = 0.0, pairs_by_chance = 0.0;
  const std::size_t n = axes[0].y.size();
  for (std::size_t b = 1; b < n; b += kRepeatBlock) {
    std::array<double, 3> alone{};
    double in_two = 0.0;
    std::vector<std::size_t> here_rows;
    double looked_at = 0.0;
    std::size_t run = 0, longest = 0;
    for (std::size_t i = b; i < std::min(b + kRepeatBlock, n); ++i) {
      if (!ignore.empty() && ignore[i] != 0) continue;
      if (!std::all_of(axes.begin(), axes.end(), [i](const Axis& a) { return measured(a, i) && measured(a, i - 1); }))
        continue;
      if (!changes_around(axes, i)) continue;
      ++looked_at;
      const auto repeats = [&](std::size_t a) { return axes[a].y[i] == axes[a].y[i - 1]; };
      const bool zero = axes[0].y[i] == 0.0 && axes[1].y[i] == 0.0 && axes[2].y[i] == 0.0;  // a dead zone's work
      if (repeats(0) && repeats(1) && repeats(2) && !zero) {
        here_rows.push_back(i);
        longest = std::max(longest, ++run);
        continue;
      }
      run = 0;
      for (std::size_t a = 0; a < 3; ++a) alone[a] += repeats(a);
      in_two += repeats(0) + repeats(1) + repeats(2) == 2;
    }
    // Axes that repeat alone tell how often all three would: at rest on a coarse lattice often, in motion never.
    if (longest >= kLongestRun) continue;  // a body at rest within one step of its lattice
    double here = looked_at;
    for (const double x : alone) here *= (x + 0.5) / (looked_at - static_cast<double>(here_rows.size()) + 1.0);
    chance += here;
    pairs += in_two;
    for (std::size_t a = 0; a < 3; ++a) pairs_by_chance += alone[a] * alone[(a + 1) % 3] / std::max(looked_at, 1.0);
    rows.insert(rows.end(), here_rows.begin(), here_rows.end());
  }
  // What moves all axes alike - a line near half the rate as it beats with the rows - lets them repeat together, each
  // pair as many times too often.
  if (pairs_by_chance > kPairsToCompare) chance *= std::pow(std::max(pairs / pairs_by_chance, 1.0), 3);
  if (static_cast<double>(rows.size()) < kFewestRepeats + kBeyondChance * chance) return {};
  return rows;
}

std::optional<BitFlips> find_bit_flips(const Axis& axis) {
  const double step = axis.lattice.step > 0 ? axis.lattice.step : axis.printed;
  if (!(step > 0)) return std::nullopt;
  const std::vector<Spike> spikes = spikes_of(axis);
  BitFlips out;
  double by_chance = 0.0;
  for (const Spike& s : spikes) {
    const double steps = std::abs(s.size) / step, bit = std::round(std::log2(steps));
    const double power = std::exp2(bit), tolerance = 3.0 * s.scale / step + 0.5;
    if (power < kLeastFlip_steps) continue;
    by_chance += std::min(1.0, 2.0 * tolerance / (0.7 * power));
    if (std::abs(steps - power) > tolerance) continue;
    out.rows.push_back(s.row);
    out.lowest_bit = std::min(out.lowest_bit, static_cast<int>(bit));
    out.highest_bit = std::max(out.highest_bit, static_cast<int>(bit));
  }
  const auto found = static_cast<double>(out.rows.size());
  if (out.rows.size() < kFewestFlips || found < kFlipShare * static_cast<double>(spikes.size())) return std::nullopt;
  if (found < by_chance + 4.0 * std::sqrt(by_chance + 1.0)) return std::nullopt;
  return out;
}

std::optional<MissingCodes> find_missing_codes(const Axis& axis) {
  const double step = axis.lattice.step > 0 ? axis.lattice.step : axis.printed;
  if (!(step > 0)) return std::nullopt;
  std::vector<long long> codes;
  for (std::size_t i = 0; i < axis.y.size(); ++i)
    if (measured(axis, i)) codes.push_back(std::llround((axis.y[i] - axis.lattice.origin) / step));
  if (codes.empty()) return std::nullopt;
  const auto [low, high] = std::minmax_element(codes.begin(), codes.end());
  if (*high - *low > kMostCodes) return std::nullopt;
  std::vector<double> count(static_cast<std::size_t>(*high - *low) + 1, 0.0);
  for (const long long c : codes) ++count[static_cast<std::size_t>(c - *low)];
  for (int bits = 2; bits <= kMostBits; ++bits) {
    const auto modulus = static_cast<std::size_t>(1) << bits;
    if (count.size() < 4 * modulus) break;  // readings that stay put pass few codes
    const std::vector<bool> absent = absent_residues(count, modulus);
    const auto missing = static_cast<std::size_t>(std::count(absent.begin(), absent.end(), true));
    if (missing == 0 || 2 * missing > modulus || is_coarser_lattice(absent)) continue;
    MissingCodes out{.modulus = static_cast<int>(modulus)};
    for (std::size_t r = 0; r < modulus; ++r)
      if (absent[r]) out.absent.push_back(static_cast<int>(r));
    out.expected = readings_due(count, absent);
    if (out.expected > kExpectedReadings * static_cast<double>(missing)) return out;
  }
  return std::nullopt;
}

}  // namespace stillpoint::diag::detail
