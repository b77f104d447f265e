/// Where the open numbers of a text are looked for.
#pragma once
#include <vector>

#include <Eigen/Core>

namespace stillpoint::diag {

/// `from`, `from` ratio, ... up to `to`.
[[nodiscard]] std::vector<double> geometric(double from, double to, double ratio);

/// Thresholds of a driver: at shares of its values, and between the states of one that is switched; ascending.
[[nodiscard]] std::vector<double> levels_in(const Eigen::MatrixXd& x);

}  // namespace stillpoint::diag
