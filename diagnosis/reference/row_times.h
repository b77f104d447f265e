/// When rows were taken: evenly, or each at the time of its own stamp.
#pragma once
#include "diagnosis/reference/series.h"

namespace stillpoint::diag {

struct RowTimes {
  double step_s = 0.0;  ///< the mean one
  Series t_s;           ///< of every row, increasing; empty: row i was taken at i steps

  [[nodiscard]] bool even() const { return t_s.size() == 0; }
  [[nodiscard]] double at(Eigen::Index row) const { return even() ? static_cast<double>(row) * step_s : t_s[row]; }
};

/// Weights that give the value and the first derivatives at `at` of the polynomial through values at `nodes`: nodes x
/// (orders + 1). Fornberg, "Calculation of Weights in Finite Difference Formulas", SIAM Review 40 (1998), p. 687.
[[nodiscard]] Eigen::MatrixXd polynomial_weights(const Series& nodes, double at, int orders);

/// Which of the two times a row has: an uneven clock makes a smooth motion rough wherever it is not the clock of the
/// motion. The stamps, where a reference is smoother with them than with even rows; else even rows, of which stamps are
/// a rounded or late account. `turns` (n x 4, of one branch) and `places` (n x 3, may be empty) are not finite where
/// the reference is missing.
[[nodiscard]] RowTimes times_of_rows(const Series& stamp_s, double step_s, const Eigen::MatrixXd& turns,
                                     const Eigen::MatrixXd& places);

/// Standard deviation of one component of x off the curve through its eight neighbours on either side, where it moves:
/// noise, rounding of values or of stamps, or a motion too fast for the rows.
[[nodiscard]] double roughness(const Eigen::MatrixXd& x, const RowTimes& rows);

/// x at other times, by the polynomial through `reach` rows on either side; beyond the ends the end value.
[[nodiscard]] Series3 at_times(const Series3& x, const RowTimes& rows, const Series& at_s, Eigen::Index reach);

}  // namespace stillpoint::diag
