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

  [[nodiscard]] Eigen::Index cols() const { return at_knots_.rows(); }
  /// K x K: whitened columns' * whitened columns.
  [[nodiscard]] Eigen::MatrixXd gram() const;
  /// K x p: whitened columns' * x, where x is n x p.
  [[nodiscard]] Eigen::MatrixXd products(const Eigen::MatrixXd& x) const;
  /// n x p: whitened columns * coefficients, K x p.
  [[nodiscard]] Eigen::MatrixXd times(const Eigen::MatrixXd& coefficients) const;

 private:
  /// Rows from one knot to the next, which stands at `begin + count`; a row alone is its own knot.
  struct Span {
    Eigen::Index begin = 0, count = 0, knot = 0;
  };
  std::vector<Span> spans_;
  Series of_this_, of_next_;  ///< share of each row in its span's knot and in the next, times the noise model's scale
  Eigen::MatrixXd at_knots_;  ///< K x knots: filtered, not scaled
};

}  // namespace stillpoint::diag
