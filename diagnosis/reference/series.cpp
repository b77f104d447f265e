#include "diagnosis/reference/series.h"

#include <algorithm>

namespace stillpoint::diag {

Series3 filled3(const std::vector<Vec3>& column) {
  const auto n = static_cast<Eigen::Index>(column.size());
  Series3 out(n, 3);
  for (int a = 0; a < 3; ++a)
    out.col(a) = filled(n, [&](Eigen::Index i) { return column[static_cast<std::size_t>(i)][a]; });
  return out;
}

Series moving_mean(const Series& x, Eigen::Index half) {
  const Eigen::Index n = x.size();
  Series sum(n + 1), out(n);
  sum[0] = 0;
  for (Eigen::Index i = 0; i < n; ++i) sum[i + 1] = sum[i] + x[i];
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::Index reach = std::min({half, i, n - 1 - i});
    out[i] = (sum[i + reach + 1] - sum[i - reach]) / static_cast<double>(2 * reach + 1);
  }
  return out;
}

double quantile(const Series& x, double share) {
  return quantile(std::vector<double>(x.data(), x.data() + x.size()), share);
}

}  // namespace stillpoint::diag
