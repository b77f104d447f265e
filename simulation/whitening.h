/// Exact whitening of records whose noise is white plus Gauss-Markov processes: the innovations of the Kalman filter of
/// that noise, divided by their standard deviation. They are what the inverse Cholesky factor of the record's whole
/// covariance would give, in time proportional to its length. After Kailath, Sayed, Hassibi, "Linear Estimation"
/// (2000), ch. 9.
#pragma once
#include <Eigen/Core>

#include "simulation/noise.h"

namespace stillpoint::sim {

class Whitener {
 public:
  /// Signals that are whitened side by side: a change, and 1, x, y, z of the true vector, its regressors.
  using Row = Eigen::Matrix<double, 1, 5>;

  explicit Whitener(const NoiseModel& noise);
  /// Whitened values of a row that was measured. A row without any noise gives zeros: it has no finite weight.
  Row whiten(const Row& signals);
  /// To the next row; call it for rows that were not measured, too.
  void advance();

 private:
  double white_variance_;
  Eigen::VectorXd keep_, drive_variance_, gain_;
  Eigen::MatrixXd covariance_;
  Eigen::Matrix<double, Eigen::Dynamic, 5> state_;
};

}  // namespace stillpoint::sim
