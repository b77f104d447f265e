/// A law over a whole recording: every operation on columns of numbers.
#pragma once
#include <Eigen/Core>
#include <map>
#include <string>

#include "laws/expression.h"

namespace stillpoint::laws {

/// Over how many seconds to either side d() of it looks, where its argument follows the thermometer alone: its noise
/// must not become a rate. 0: from row to row.
[[nodiscard]] double rate_span_s(const Node& rate);

struct Columns {
  Eigen::VectorXd t_s;  ///< increasing
  /// n x 1 or n x 3 by driver; a rate may stand here under its own text ("d(w)") where it is known better than by
  /// differences.
  std::map<std::string, Eigen::MatrixXd, std::less<>> values;
};

/// n x 1 or n x 3. Pre: checked, all its drivers are among the columns but t, which is t_s - t_s[0].
[[nodiscard]] Eigen::MatrixXd evaluate(const Node& tree, const Columns& columns);

}  // namespace stillpoint::laws
