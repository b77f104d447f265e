/// Columns that hardly change from row to row, whitened: known at knots and straight between them. A random walk has
/// forty of them, and every hypothesis is fitted beside it; so what their products cost goes with the knots.
#pragma once
#include <vector>

#include "diagnosis/reference/noise_model.h"

namespace stillpoint::diag {

class SlowColumns {
 public:
  SlowColumns() = default;
  /// `columns`: n x K, of which the fastest has K half waves along the rows.
  SlowColumns(const Layout& layout, const Eigen::MatrixXd& columns, const NoiseModel& noise, int axis);

  [[nodiscard]] Eigen::Index cols() const { return at_knots_.cols(); }
  /// K x K: whitened columns' * whitened columns.
  [[nodiscard]] Eigen::MatrixXd gram() const;
  /// K x p: whitened columns' * x, where x is n x p.
  [[nodiscard]] Eigen::MatrixXd products(const Eigen::MatrixXd& x) const;
  /// n x p: whitened columns * coefficients, K x p.
  [[nodiscard]] Eigen::MatrixXd times(const Eigen::MatrixXd& coefficients) const;

 private:
  /// Rows from one knot to the next, which stands at `end`; or the last row of all, which is its own knot.
  struct Span {
    Eigen::Index begin = 0, end = 0, knot = 0;
    [[nodiscard]] double share(Eigen::Index row) const {
      return static_cast<double>(row - begin) / static_cast<double>(end - begin);
    }
  };
  std::vector<Span> spans_;
  Series scale_;              ///< of each row: the noise model's, 0 where it does not count
  Eigen::MatrixXd at_knots_;  ///< filtered, not scaled
};

}  // namespace stillpoint::diag
