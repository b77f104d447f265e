/// Penalised regression spline of degree 5 with evenly spaced knots: second derivatives are smooth, so that a reference
/// trajectory gives accelerations. After Eilers, Marx, "Flexible smoothing with B-splines and penalties", Stat. Sci. 11
/// (1996), with fifth differences as penalty (the ends keep their
/// acceleration); the penalty is chosen by generalised cross-validation.
#pragma once
#include <array>
#include <cstddef>
#include <vector>

#include "core/types.h"
#include "simulation/taylor.h"

namespace stillpoint::sim {

/// Weighted samples of a curve in `Columns` dimensions at strictly increasing times.
template <int Columns>
struct CurveSamples {
  std::vector<double> t_s, weight;
  std::vector<Eigen::Matrix<double, Columns, 1>> value;
};

template <int Columns>
class SmoothingSpline {
 public:
  using Point = Eigen::Matrix<double, Columns, 1>;

  /// Pre: at least two samples. Penalty by generalised cross-validation over 1e-10 ... 1e4.
  SmoothingSpline(const CurveSamples<Columns>& samples, double knot_step_s);

  [[nodiscard]] std::array<Taylor, Columns> at(double t_s) const noexcept;
  /// Makes the curve exactly constant wherever only coefficients between these times act.
  void hold(double from_s, double to_s, const Point& value);
  [[nodiscard]] double penalty() const noexcept { return penalty_; }

 private:
  /// Residual sum of squares of the fit with this penalty; leaves the coefficients.
  double solve(const CurveSamples<Columns>& samples, double penalty);

  double start_s_, step_s_, penalty_ = 0.0;
  std::vector<Point> coefficients_;
};

extern template class SmoothingSpline<3>;
extern template class SmoothingSpline<4>;

}  // namespace stillpoint::sim
