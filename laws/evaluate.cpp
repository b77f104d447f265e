#include "laws/evaluate.h"

#include <algorithm>
#include <cmath>

#include "core/cross_rows.h"
#include "core/result.h"
#include "laws/elementwise.h"

namespace stillpoint::laws {
namespace {

using Matrix = Eigen::MatrixXd;
using Series = Eigen::VectorXd;

constexpr double kThermometerSpan_s = 1.0;

/// Row by row between the neighbours; the end values beyond the ends.
Matrix at_times(const Matrix& x, const Series& t, const Series& wanted) {
  Matrix out(wanted.size(), x.cols());
  Eigen::Index k = 0;
  const Eigen::Index last = t.size() - 1;
  for (Eigen::Index i = 0; i < wanted.size(); ++i) {
    const double at = std::clamp(wanted[i], t[0], t[last]);
    while (k > 0 && t[k] > at) --k;
    while (k + 1 < last && t[k + 1] <= at) ++k;
    if (last == 0) {
      out.row(i) = x.row(0);
      continue;
    }
    const double share = (at - t[k]) / (t[k + 1] - t[k]);
    out.row(i) = (1.0 - share) * x.row(k) + share * x.row(k + 1);
  }
  return out;
}

Matrix rate(const Matrix& x, const Series& t, double span_s) {
  const Eigen::Index n = t.size();
  if (n < 2) return Matrix::Zero(n, x.cols());
  if (span_s > 0.0) {
    const Series later = (t.array() + span_s).min(t[n - 1]), earlier = (t.array() - span_s).max(t[0]);
    const Series width = later - earlier;
    return (at_times(x, t, later) - at_times(x, t, earlier)).array().colwise() / width.array();
  }
  Matrix out(n, x.cols());
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::Index a = std::max<Eigen::Index>(i - 1, 0), b = std::min(i + 1, n - 1);
    out.row(i) = (x.row(b) - x.row(a)) / (t[b] - t[a]);
  }
  return out;
}

Matrix integral(const Matrix& x, const Series& t) {
  Matrix out = Matrix::Zero(x.rows(), x.cols());
  for (Eigen::Index i = 1; i < x.rows(); ++i)
    out.row(i) = out.row(i - 1) + 0.5 * (t[i] - t[i - 1]) * (x.row(i) + x.row(i - 1));
  return out;
}

/// Exact for an input that runs straight between the rows.
Matrix lag(const Matrix& x, const Series& t, double tau_s) {
  Matrix out = x;
  for (Eigen::Index i = 1; i < x.rows(); ++i) {
    const double step = t[i] - t[i - 1], keep = std::exp(-step / tau_s);
    const double slope = (step - tau_s * (1.0 - keep)) / step;
    out.row(i) = keep * out.row(i - 1) + (1.0 - keep) * x.row(i - 1) + slope * (x.row(i) - x.row(i - 1));
  }
  return out;
}

Matrix play(const Matrix& x, double width) {
  Matrix out = x;
  for (Eigen::Index i = 1; i < x.rows(); ++i)
    for (Eigen::Index c = 0; c < x.cols(); ++c)
      out(i, c) = std::clamp(out(i - 1, c), x(i, c) - 0.5 * width, x(i, c) + 0.5 * width);
  return out;
}

Matrix product(const Matrix& a, const Matrix& b) {
  if (a.cols() == b.cols()) return a.cwiseProduct(b);
  return a.cols() == 1 ? b.array().colwise() * a.col(0).array() : a.array().colwise() * b.col(0).array();
}

Matrix leaf(const Node& n, const Columns& c) {
  const Eigen::Index rows = c.t_s.size();
  if (n.op == Op::kNumber) return Matrix::Constant(rows, 1, n.number);
  const auto found = c.values.find(n.driver);
  if (found == c.values.end() && n.driver == "t") return c.t_s.array() - c.t_s[0];
  SP_EXPECTS(found != c.values.end());
  return n.op == Op::kDriver ? found->second : Matrix(found->second.col(static_cast<Eigen::Index>(n.component)));
}

}  // namespace

double rate_span_s(const Node& rate) {
  const auto drivers = drivers_of(rate);
  return drivers.size() == 1 && drivers.front() == "T" ? kThermometerSpan_s : 0.0;
}

Eigen::MatrixXd evaluate(const Node& n, const Columns& c) {
  if (n.args.empty()) return leaf(n, c);
  if (n.op == Op::kRate)
    if (const auto known = c.values.find(text(n)); known != c.values.end()) return known->second;
  const Matrix a = evaluate(n.args[0], c);
  const double second = n.args.size() > 1 ? n.args[1].number : 0.0;
  const bool two =
      n.op == Op::kAdd || n.op == Op::kSubtract || n.op == Op::kMultiply || n.op == Op::kDivide || n.op == Op::kCross;
  const Matrix b = two ? evaluate(n.args[1], c) : Matrix{};
  switch (n.op) {
    case Op::kAdd:
      return a + b;
    case Op::kSubtract:
      return a - b;
    case Op::kMultiply:
      return product(a, b);
    case Op::kDivide:
      return product(a, b.cwiseInverse());
    case Op::kCross:
      return cross_rows(a, b);
    case Op::kRate:
      return rate(a, c.t_s, rate_span_s(n));
    case Op::kIntegral:
      return integral(a, c.t_s);
    case Op::kLag:
      return lag(a, c.t_s, second);
    case Op::kDelay:
      return at_times(a, c.t_s, c.t_s.array() - second);
    case Op::kPlay:
      return play(a, second);
    case Op::kNorm:
      return a.rowwise().norm();
    default:
      return elementwise(n.op, a, second);
  }
}

}  // namespace stillpoint::laws
