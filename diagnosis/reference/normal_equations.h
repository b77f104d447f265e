/// The normal equations of one fit: offset and matrix of each axis, columns that the axes share, a walk in each axis.
#pragma once
#include "diagnosis/reference/regression.h"
#include "diagnosis/reference/slow_columns.h"

namespace stillpoint::diag {

/// What is fitted, under which noise; without the walk where none is wanted. `layout`: the target's, or a whiter one.
struct Problem {
  const Target& t;
  const Layout& layout;
  const Columns& columns;
  const NoiseModel& noise;
  bool may_walk = true;
  [[nodiscard]] Eigen::Index own() const { return t.nuisance.cols(); }  ///< unknowns of one axis: offset and matrix
  [[nodiscard]] Eigen::Index plain() const { return 3 * own() + static_cast<Eigen::Index>(columns.size()); }
  [[nodiscard]] Eigen::Index walk() const { return may_walk ? t.walk_terms() : 0; }
  [[nodiscard]] Eigen::Index walk_in(const Eigen::VectorXd& x) const { return x.size() > plain() ? walk() : 0; }
};

/// One axis, whitened, as normal equations: nuisance and columns first, the walk last, so that the model without a walk
/// is the top left corner.
struct AxisSystem {
  Eigen::MatrixXd design;  ///< nuisance and columns; the last is the residual
  SlowColumns walk;
  std::vector<Eigen::Index> global;  ///< index of each column of the design among all unknowns
  Eigen::Index plain = 0;            ///< columns of the design but for the residual
  Eigen::MatrixXd gram;              ///< of design and walk
  Eigen::VectorXd moment;            ///< the same with the residual
};
using Systems = std::array<AxisSystem, 3>;

[[nodiscard]] AxisSystem whitened_system(const Problem& of, int axis);
[[nodiscard]] inline Systems whitened_systems(const Problem& of) {
  return {whitened_system(of, 0), whitened_system(of, 1), whitened_system(of, 2)};
}

[[nodiscard]] inline bool any_walks(const std::array<double, 3>& q) { return q[0] > 0 || q[1] > 0 || q[2] > 0; }

/// The rate of one axis' walk. One that it does not need is pinned there.
[[nodiscard]] double walk_of(const std::array<double, 3>& q, const NoiseModel& noise, int axis);

struct Solution {
  Eigen::VectorXd x;        ///< nuisance of the three axes, columns, walk of the three axes
  Eigen::MatrixXd inverse;  ///< of the normal matrix: all rows, the columns of nuisance and candidates
  double log_det = 0.0;     ///< of the walk, marginalised
  /// Of one axis: as the design has them, then its walk.
  [[nodiscard]] Eigen::VectorXd of_axis(const Problem& of, const AxisSystem& a, int axis) const {
    const Eigen::Index K = of.walk_in(x);
    Eigen::VectorXd own(a.plain + K);
    for (Eigen::Index i = 0; i < a.plain; ++i) own[i] = x[a.global[static_cast<std::size_t>(i)]];
    own.tail(K) = x.segment(of.plain() + axis * K, K);
    return own;
  }
};

/// With these rates of the walks, unit / sqrt(s); without any where all are 0.
[[nodiscard]] Solution solve_normal(const Problem& of, const Systems& systems, const std::array<double, 3>& walk_q);

/// Of so many rows, the residual minus what these unknowns do; without walks where `x` has none.
[[nodiscard]] Series3 leftover_of(const Problem& of, const Eigen::VectorXd& x, Eigen::Index begin, Eigen::Index rows);
[[nodiscard]] inline Series3 leftover_of(const Problem& of, const Solution& s) {
  return leftover_of(of, s.x, 0, of.t.layout.n);
}

}  // namespace stillpoint::diag
