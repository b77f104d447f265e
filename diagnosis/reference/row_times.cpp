#include "diagnosis/reference/row_times.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/reference/differences.h"

namespace stillpoint::diag {
namespace {

constexpr double kEvenEnough_s = 1e-7;   // a hand turns by a microradian meanwhile
constexpr double kShortestStep = 0.2;    // of the mean one; closer rows blow up any difference
constexpr double kSmoother = 0.85;       // noise of a camera is as rough with either clock, to a few percent
constexpr double kMoving = 0.9;          // share of the rows that are rougher in the tenth that moves most
constexpr double kQuantileOverSd = 2.5;  // of the length of three components: that share of white ones lies below

bool nearly_even(const Series& t_s) {
  const Eigen::Index n = t_s.size();
  const Series bend = t_s.head(n - 2) - 2.0 * t_s.segment(1, n - 2) + t_s.tail(n - 2);
  return quantile(bend.cwiseAbs(), kMoving) < kEvenEnough_s;
}

double ratio_of_roughness(const Eigen::MatrixXd& x, const RowTimes& even, const RowTimes& stamped) {
  const double before = x.rows() == 0 ? 0.0 : roughness(x, even);
  return before > 0.0 ? roughness(x, stamped) / before : 1.0;
}

}  // namespace

Eigen::MatrixXd polynomial_weights(const Series& nodes, double at, int orders) {
  Eigen::MatrixXd c = Eigen::MatrixXd::Zero(nodes.size(), orders + 1);
  c(0, 0) = 1.0;
  double before = 1.0, offset = nodes[0] - at;
  for (Eigen::Index i = 1; i < nodes.size(); ++i) {
    const Eigen::Index highest = std::min<Eigen::Index>(i, orders);
    const double last_offset = offset;
    double product = 1.0;
    offset = nodes[i] - at;
    for (Eigen::Index j = 0; j < i; ++j) {
      const double apart = nodes[i] - nodes[j];
      product *= apart;
      for (Eigen::Index k = highest; j == i - 1 && k >= 0; --k)
        c(i, k) = before * ((k > 0 ? static_cast<double>(k) * c(j, k - 1) : 0.0) - last_offset * c(j, k)) / product;
      for (Eigen::Index k = highest; k >= 0; --k)
        c(j, k) = (offset * c(j, k) - (k > 0 ? static_cast<double>(k) * c(j, k - 1) : 0.0)) / apart;
    }
    before = product;
  }
  return c;
}

double roughness(const Eigen::MatrixXd& x, const RowTimes& rows) {
  const Eigen::Index reach = kStencilReach;
  std::vector<double> off;
  Series nodes(2 * reach);
  for (Eigen::Index i = reach; i + reach < x.rows(); ++i) {
    for (Eigen::Index k = 0; k < reach; ++k) {
      nodes[k] = (rows.at(i - reach + k) - rows.at(i)) / rows.step_s;
      nodes[reach + k] = (rows.at(i + 1 + k) - rows.at(i)) / rows.step_s;
    }
    const Eigen::VectorXd w = polynomial_weights(nodes, 0.0, 0);
    const Eigen::RowVectorXd between = w.head(reach).transpose() * x.middleRows(i - reach, reach) +
                                       w.tail(reach).transpose() * x.middleRows(i + 1, reach);
    const double distance = (x.row(i) - between).norm() / std::sqrt(1.0 + w.squaredNorm());
    if (std::isfinite(distance)) off.push_back(distance);
  }
  return off.empty() ? 0.0
                     : quantile(Eigen::Map<const Series>(off.data(), static_cast<Eigen::Index>(off.size())), kMoving) /
                           kQuantileOverSd;
}

RowTimes times_of_rows(const Series& stamp_s, double step_s, const Eigen::MatrixXd& turns,
                       const Eigen::MatrixXd& places) {
  RowTimes even{step_s, {}};
  const RowTimes stamped{step_s, stamp_s};
  const Eigen::Index n = stamp_s.size();
  if (n < 3 || nearly_even(stamp_s) || (stamp_s.tail(n - 1) - stamp_s.head(n - 1)).minCoeff() < kShortestStep * step_s)
    return even;
  return ratio_of_roughness(turns, even, stamped) * ratio_of_roughness(places, even, stamped) < kSmoother ? stamped
                                                                                                          : even;
}

Series3 at_times(const Series3& x, const RowTimes& rows, const Series& at_s, Eigen::Index reach) {
  const Eigen::Index n = x.rows(), points = std::min(2 * reach, n);
  Series3 out(at_s.size(), 3);
  Series nodes(points);
  for (Eigen::Index i = 0; i < at_s.size(); ++i) {
    const double at = std::clamp(at_s[i], rows.at(0), rows.at(n - 1));
    const Eigen::Index before = rows.even()
                                    ? static_cast<Eigen::Index>(std::floor(at / rows.step_s))
                                    : std::upper_bound(rows.t_s.data(), rows.t_s.data() + n, at) - rows.t_s.data() - 1;
    const Eigen::Index first = std::clamp<Eigen::Index>(before - reach + 1, 0, n - points);
    for (Eigen::Index k = 0; k < points; ++k) nodes[k] = (rows.at(first + k) - at) / rows.step_s;
    out.row(i) = polynomial_weights(nodes, 0.0, 0).transpose() * x.middleRows(first, points);
  }
  return out;
}

}  // namespace stillpoint::diag
