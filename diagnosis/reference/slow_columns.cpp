#include "diagnosis/reference/slow_columns.h"

#include <algorithm>

namespace stillpoint::diag {
namespace {

constexpr Eigen::Index kKnotsAHalfWave = 16;  // straight between them to (pi / 16)^2 / 8 of the fastest column

}  // namespace

SlowColumns::SlowColumns(const Layout& layout, const Eigen::MatrixXd& columns, const NoiseModel& noise, int axis)
    : scale_(noise.scale(layout, axis)) {
  const Eigen::Index K = columns.cols();
  if (K == 0) return;
  const Eigen::Index every = std::max<Eigen::Index>(1, layout.n / (K * kKnotsAHalfWave));
  std::vector<std::pair<Eigen::Index, int>> knots;  // row, regime
  for (const Segment& g : layout.segments) {
    // No row counts before its history is whole.
    for (Eigen::Index row = g.begin + layout.order; row < g.end;) {
      const Eigen::Index next = row + 1 == g.end ? g.end : std::min(row + every, g.end - 1);
      spans_.push_back({row, next, static_cast<Eigen::Index>(knots.size())});
      knots.emplace_back(row, g.regime);
      row = next;
    }
  }
  at_knots_.resize(static_cast<Eigen::Index>(knots.size()), K);
  for (std::size_t i = 0; i < knots.size(); ++i) {
    const auto& [row, regime] = knots[i];
    const Eigen::VectorXd& a = noise.coefficients(regime, axis);
    auto at = at_knots_.row(static_cast<Eigen::Index>(i));
    at = columns.row(row);
    for (Eigen::Index j = 0; j < a.size(); ++j) at -= a[j] * columns.row(row - j - 1);
  }
}

Eigen::MatrixXd SlowColumns::gram() const {
  Eigen::MatrixXd weighed = Eigen::MatrixXd::Zero(at_knots_.rows(), cols());
  for (const Span& s : spans_) {
    double here = 0.0, between = 0.0, there = 0.0;
    for (Eigen::Index i = s.begin; i < s.end; ++i) {
      const double u = s.share(i), w = scale_[i] * scale_[i];
      here += w * (1.0 - u) * (1.0 - u), between += w * u * (1.0 - u), there += w * u * u;
    }
    weighed.row(s.knot) += here * at_knots_.row(s.knot);
    if (there == 0.0) continue;
    weighed.row(s.knot) += between * at_knots_.row(s.knot + 1);
    weighed.row(s.knot + 1) += between * at_knots_.row(s.knot) + there * at_knots_.row(s.knot + 1);
  }
  return at_knots_.transpose() * weighed;
}

Eigen::MatrixXd SlowColumns::products(const Eigen::MatrixXd& x) const {
  Eigen::MatrixXd at = Eigen::MatrixXd::Zero(at_knots_.rows(), x.cols());
  for (Eigen::Index j = 0; j < x.cols(); ++j)
    for (const Span& s : spans_)
      for (Eigen::Index i = s.begin; i < s.end; ++i) {
        const double u = s.share(i), y = scale_[i] * x(i, j);
        at(s.knot, j) += (1.0 - u) * y;
        if (u > 0.0) at(s.knot + 1, j) += u * y;
      }
  return at_knots_.transpose() * at;
}

Eigen::MatrixXd SlowColumns::times(const Eigen::MatrixXd& coefficients) const {
  const Eigen::MatrixXd at = at_knots_ * coefficients;
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(scale_.size(), coefficients.cols());
  for (Eigen::Index j = 0; j < out.cols(); ++j)
    for (const Span& s : spans_)
      for (Eigen::Index i = s.begin; i < s.end; ++i) {
        const double u = s.share(i);
        out(i, j) = scale_[i] * (u > 0.0 ? (1.0 - u) * at(s.knot, j) + u * at(s.knot + 1, j) : at(s.knot, j));
      }
  return out;
}

}  // namespace stillpoint::diag
