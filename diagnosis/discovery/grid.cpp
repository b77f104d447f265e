#include "diagnosis/discovery/grid.h"

#include <algorithm>
#include <array>
#include <utility>

#include "diagnosis/reference/series.h"

namespace stillpoint::diag {
namespace {

constexpr std::array<double, 5> kShares{0.15, 0.35, 0.5, 0.65, 0.85};
constexpr double kGap = 0.03, kBesideAGap = 0.02;  // of a driver's range, of its rows on either side
constexpr std::size_t kMostGaps = 5;

/// In the widest gaps between the values of a driver that is switched: between two states every level is the same one.
std::vector<double> between_states(const Eigen::VectorXd& all) {
  std::vector<double> sorted(all.begin(), all.end());
  std::sort(sorted.begin(), sorted.end());
  const auto aside = static_cast<std::size_t>(kBesideAGap * static_cast<double>(sorted.size()));
  const double wide = kGap * (sorted.back() - sorted.front());
  std::vector<std::pair<double, double>> gaps;  // width, middle
  for (std::size_t i = aside; i + 1 + aside < sorted.size(); ++i)
    if (const double width = sorted[i + 1] - sorted[i]; width > wide)
      gaps.emplace_back(width, 0.5 * (sorted[i] + sorted[i + 1]));
  std::sort(gaps.rbegin(), gaps.rend());
  if (gaps.size() > kMostGaps) gaps.resize(kMostGaps);
  std::vector<double> out;
  for (const auto& gap : gaps) out.push_back(gap.second);
  return out;
}

}  // namespace

std::vector<double> geometric(double from, double to, double ratio) {
  std::vector<double> out;
  for (double x = from; x < to * 1.001; x *= ratio) out.push_back(x);
  return out;
}

std::vector<double> levels_in(const Eigen::MatrixXd& x) {
  std::vector<double> out;
  const Eigen::VectorXd all = x.reshaped();
  for (const double share : kShares) {
    const double level = quantile(all, share);
    if (out.empty() || level > out.back()) out.push_back(level);
  }
  for (const double level : between_states(all)) out.push_back(level);
  std::sort(out.begin(), out.end());
  return out;
}

}  // namespace stillpoint::diag
