/// Random expressions of the referee, as functions of a scene. Nothing here is shared with the grammar of laws/.
#pragma once
#include <Eigen/Core>
#include <functional>
#include <map>
#include <set>
#include <string>

#include "diagnosis/prove/draw.h"

namespace stillpoint::diag::invented {

/// What truly happened, row by row, evenly in time.
struct Scene {
  Eigen::VectorXd t;
  Eigen::MatrixXd w, f, m;                         ///< n x 3
  std::map<std::string, Eigen::VectorXd> scalars;  ///< T, I, V, further columns
};

struct Law {
  std::function<Eigen::MatrixXd(const Scene&)> value;  ///< n x 3
  std::string text;
  std::set<std::string> drivers;
};

/// `own`: the vector that the sensor measures (f, w, m). Thresholds and time constants fit `scene`.
[[nodiscard]] Law draw_law(Draw& draw, const Scene& scene, const std::string& own);

/// Mean over `half` rows to either side.
[[nodiscard]] Eigen::VectorXd smooth(const Eigen::VectorXd& x, Eigen::Index half);

}  // namespace stillpoint::diag::invented
