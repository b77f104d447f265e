/// Cross products of many vectors at once.
#pragma once
#include <Eigen/Core>

namespace stillpoint {

/// a_i x b_i for each row i. Pre: both n x 3.
template <class Rows>
[[nodiscard]] Rows cross_rows(const Rows& a, const Rows& b) {
  Rows out(a.rows(), 3);
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    out.col(i) = a.col(j).cwiseProduct(b.col(k)) - a.col(k).cwiseProduct(b.col(j));
  }
  return out;
}

}  // namespace stillpoint
