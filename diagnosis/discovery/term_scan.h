/// The likelihood that a candidate could gain, quickly: its columns against the residual, both whitened, with bias,
/// matrix, the target's walk and what is explained already projected out of both.
#pragma once
#include "diagnosis/reference/regression.h"
#include "diagnosis/reference/slow_columns.h"

namespace stillpoint::diag {

class TermScan {
 public:
  TermScan(const Target& target, const Columns& explained, const NoiseModel& noise);
  [[nodiscard]] double gain(const Columns& columns) const;

 private:
  /// What one axis is explained by already, whitened: `dense` and the walk, made orthonormal by `shape`.
  struct Base {
    Eigen::MatrixXd dense;
    SlowColumns walk;
    Eigen::MatrixXd shape;
    /// Shares of x, n x p, in the orthonormal columns.
    [[nodiscard]] Eigen::MatrixXd shares(const Eigen::MatrixXd& x) const;
  };
  const Target& target_;
  const NoiseModel& noise_;
  std::array<Base, 3> base_;
  std::array<Series, 3> residual_;  ///< without what the base explains
};

/// The columns of a value with its coefficients: k times a number, or a vector axis by axis; or a matrix times it.
[[nodiscard]] Columns columns_of_value(const Eigen::MatrixXd& value, bool matrix);

}  // namespace stillpoint::diag
