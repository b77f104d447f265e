/// The likelihood that a candidate could gain, quickly: its columns against the residual, both whitened, with bias,
/// matrix, the target's walk and what is explained already projected out of both.
#pragma once
#include "diagnosis/reference/regression.h"

namespace stillpoint::diag {

class TermScan {
 public:
  TermScan(const Target& target, const Columns& explained, const NoiseModel& noise);
  [[nodiscard]] double gain(const Columns& columns) const;

 private:
  const Target& target_;
  const NoiseModel& noise_;
  std::array<Eigen::MatrixXd, 3> base_;  ///< orthonormal
  std::array<Series, 3> residual_;
};

/// The columns of a value with its coefficients: k times a number, or a vector axis by axis; or a matrix times it.
[[nodiscard]] Columns columns_of_value(const Eigen::MatrixXd& value, bool matrix);

}  // namespace stillpoint::diag
