#include "diagnosis/reference/hidden_rail.h"

#include <algorithm>
#include <cmath>

namespace stillpoint::diag {
namespace {

constexpr double kBeyondScatter = 8.0;

double highest(const Series3& y, const Mask& muted) {
  double out = 0.0;
  for (Eigen::Index i = 0; i < y.rows(); ++i)
    if (!muted[static_cast<std::size_t>(i)]) out = std::max(out, y.row(i).cwiseAbs().maxCoeff());
  return out;
}

/// Of readings about the prediction, where no limit is near.
double scatter_below(double limit, const Series3& y, const Series3& predicted) {
  const auto size = predicted.array().abs();
  const auto below = (size > 0.5 * limit && size < 0.9 * limit).eval();
  return std::sqrt(below.select((y - predicted).array().square(), 0.0).sum() /
                   std::max(1.0, static_cast<double>(below.count())));
}

}  // namespace

HiddenRail hidden_rail(const Signals& s, Sensor k) {
  const Series3 y = uncorrected(s.triad[k], s.reading[k]), predicted = uncorrected(s.triad[k], s.predicted[k]);
  const double read = highest(y, s.muted[k]), missing = highest(predicted, s.muted[k]) - read;
  const bool shows = s.exact_reference || missing > kBeyondScatter * scatter_below(read, y, predicted);
  HiddenRail out{.clipped = shows ? predicted : uncorrected(s.triad[k], s.vector[k]), .levels = {}};
  const double top = highest(out.clipped, s.muted[k]);
  for (const double share : {0.6, 0.7, 0.8, 0.9}) out.levels.push_back(share * top);
  // Where the noise comes after the rail, the highest reading lies just beyond it.
  if (read < out.levels.front()) out.levels.insert(out.levels.begin(), {0.95 * read, read});
  return out;
}

}  // namespace stillpoint::diag
