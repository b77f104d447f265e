/// Columns of numbers over the samples of a recording, and what is done to them everywhere.
#pragma once
#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/median.h"
#include "core/types.h"

namespace stillpoint::diag {

using Series = Eigen::VectorXd;                            ///< one value a sample
using Series3 = Eigen::Matrix<double, Eigen::Dynamic, 3>;  ///< one column an axis
using Mask = std::vector<std::uint8_t>;                    ///< one flag a sample

/// n values of get(i); a hole (not finite) is bridged by a straight line. The caller mutes its samples.
template <class Get>
Series filled(Eigen::Index n, Get get) {
  Series x(n);
  Eigen::Index known = -1;
  for (Eigen::Index i = 0; i < n; ++i) {
    x[i] = get(i);
    if (!std::isfinite(x[i])) continue;
    for (Eigen::Index k = known + 1; k < i; ++k)
      x[k] = known < 0 ? x[i]
                       : x[known] + (x[i] - x[known]) * static_cast<double>(k - known) / static_cast<double>(i - known);
    known = i;
  }
  for (Eigen::Index k = known + 1; k < n; ++k) x[k] = known < 0 ? 0.0 : x[known];
  return x;
}

/// Of so many rows each; what is left at the end is dropped.
template <class Matrix>
Matrix means_of_rows(const Matrix& x, Eigen::Index factor) {
  if (x.rows() == 0) return x;
  const Eigen::Index n = x.rows() / factor;
  Matrix out = Matrix::Zero(n, x.cols());
  for (Eigen::Index i = 0; i < n; ++i) out.row(i) = x.middleRows(i * factor, factor).colwise().mean();
  return out;
}

/// Calls visit(begin, end) for each run of rows i, the first before `end`, for which holds(i).
template <class Holds, class Visit>
void each_run(Eigen::Index n, const Holds& holds, const Visit& visit) {
  for (Eigen::Index begin = 0, end = 0; begin < n; begin = end + 1) {
    for (end = begin; end < n && holds(end);) ++end;
    if (end > begin) visit(begin, end);
  }
}

[[nodiscard]] Series3 filled3(const std::vector<Vec3>& column);

/// Over `half` neighbours on either side, fewer at the ends: symmetric, so a slope is not shifted.
[[nodiscard]] Series moving_mean(const Series& x, Eigen::Index half);

using stillpoint::quantile;
[[nodiscard]] double quantile(const Series& x, double share);  ///< as in core/median.h

}  // namespace stillpoint::diag
