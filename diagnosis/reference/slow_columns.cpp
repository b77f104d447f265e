#include "diagnosis/reference/slow_columns.h"

#include <algorithm>

namespace stillpoint::diag {
namespace {

constexpr Eigen::Index kKnotsAHalfWave = 16;  // straight between them to (pi / 16)^2 / 8 of the fastest column

}  // namespace

SlowColumns::SlowColumns(const Layout& layout, const Eigen::MatrixXd& columns, const NoiseModel& noise, int axis)
    : of_this_(noise.scale(layout, axis)), of_next_(Series::Zero(layout.n)) {
  const Eigen::Index K = columns.cols();
  if (K == 0) return;
  const Eigen::Index every = std::max<Eigen::Index>(1, layout.n / (K * kKnotsAHalfWave));
  std::vector<std::pair<Eigen::Index, int>> knots;  // row, regime
  for (const Segment& g : layout.segments) {
    // No row counts before its history is whole.
    for (Eigen::Index row = g.begin + layout.order; row < g.end;) {
      const Eigen::Index next = row + 1 == g.end ? g.end : std::min(row + every, g.end - 1), count = next - row;
      spans_.push_back({row, count, static_cast<Eigen::Index>(knots.size())});
      knots.emplace_back(row, g.regime);
      const Eigen::ArrayXd share =
          Eigen::ArrayXd::LinSpaced(count, 0.0, static_cast<double>(count - 1)) / static_cast<double>(count);
      of_next_.segment(row, count) = of_this_.segment(row, count).array() * share;
      of_this_.segment(row, count) -= of_next_.segment(row, count);
      row = next;
    }
  }
  at_knots_.resize(K, static_cast<Eigen::Index>(knots.size()));
  std::array<Eigen::VectorXd, 2> filter;  // from the oldest row to the knot's own
  for (int regime = 0; regime < layout.regimes; ++regime) {
    Eigen::VectorXd& f = filter[static_cast<std::size_t>(regime)];
    f.resize(layout.order + 1);
    f << -noise.coefficients(regime, axis).reverse(), 1.0;
  }
  for (Eigen::Index k = 0; k < K; ++k)
    for (std::size_t i = 0; i < knots.size(); ++i) {
      const auto& [row, regime] = knots[i];
      at_knots_(k, static_cast<Eigen::Index>(i)) =
          columns.col(k).segment(row - layout.order, layout.order + 1).dot(filter[static_cast<std::size_t>(regime)]);
    }
}

Eigen::MatrixXd SlowColumns::gram() const {
  Eigen::MatrixXd weighed = Eigen::MatrixXd::Zero(cols(), at_knots_.cols());
  for (const Span& s : spans_) {
    const auto here = of_this_.segment(s.begin, s.count), there = of_next_.segment(s.begin, s.count);
    weighed.col(s.knot) += here.squaredNorm() * at_knots_.col(s.knot);
    if (s.count == 1) continue;
    const double between = here.dot(there);
    weighed.col(s.knot) += between * at_knots_.col(s.knot + 1);
    weighed.col(s.knot + 1) += between * at_knots_.col(s.knot) + there.squaredNorm() * at_knots_.col(s.knot + 1);
  }
  return weighed * at_knots_.transpose();
}

Eigen::MatrixXd SlowColumns::products(const Eigen::MatrixXd& x) const {
  Eigen::MatrixXd at = Eigen::MatrixXd::Zero(at_knots_.cols(), x.cols());
  for (Eigen::Index j = 0; j < x.cols(); ++j)
    for (const Span& s : spans_) {
      const auto rows = x.col(j).segment(s.begin, s.count);
      at(s.knot, j) += of_this_.segment(s.begin, s.count).dot(rows);
      if (s.count > 1) at(s.knot + 1, j) += of_next_.segment(s.begin, s.count).dot(rows);
    }
  return at_knots_ * at;
}

Eigen::MatrixXd SlowColumns::times(const Eigen::MatrixXd& coefficients) const {
  const Eigen::MatrixXd at = at_knots_.transpose() * coefficients;
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(of_this_.size(), coefficients.cols());
  for (Eigen::Index j = 0; j < out.cols(); ++j)
    for (const Span& s : spans_) {
      out.col(j).segment(s.begin, s.count) = at(s.knot, j) * of_this_.segment(s.begin, s.count);
      if (s.count > 1) out.col(j).segment(s.begin, s.count) += at(s.knot + 1, j) * of_next_.segment(s.begin, s.count);
    }
  return out;
}

}  // namespace stillpoint::diag
