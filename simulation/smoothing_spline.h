/// Penalised regression spline of degree 5 with evenly spaced knots: second derivatives are smooth, so that a reference
/// trajectory gives accelerations. After Eilers, Marx, "Flexible smoothing with B-splines and penalties", Stat. Sci. 11
/// (1996), with fifth differences as penalty (the ends keep their acceleration).
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

  /// Pre: at least two samples.
  SmoothingSpline(const CurveSamples<Columns>& samples, double knot_step_s, double penalty);

  [[nodiscard]] std::array<Taylor, Columns> at(double t_s) const noexcept;
  /// Makes the curve exactly constant wherever only coefficients between these times act.
  void hold(double from_s, double to_s, const Point& value);
  /// Weighted sum of the squared distances to these samples.
  [[nodiscard]] double residual(const CurveSamples<Columns>& samples) const;

 private:
  double start_s_, step_s_;
  std::vector<Point> coefficients_;
};

/// Share of a sine of `frequency` (cycles per knot) that the spline passes, for one sample a knot:
/// h^2 / (h^2 + penalty (2 sin(pi f))^10), h the spectrum of the basis at the samples, (66 + 52 cos + 2 cos 2) / 120.
[[nodiscard]] double spline_gain(double frequency, double penalty);

/// The penalties that are tried, a decade apart.
[[nodiscard]] const std::vector<double>& spline_penalties();

/// The penalty of the least generalised cross-validation score: right where the errors of the samples are white.
template <int Columns>
[[nodiscard]] double cross_validated_penalty(const CurveSamples<Columns>& samples, double knot_step_s);

extern template class SmoothingSpline<3>;
extern template class SmoothingSpline<4>;
extern template double cross_validated_penalty(const CurveSamples<3>&, double);
extern template double cross_validated_penalty(const CurveSamples<4>&, double);

}  // namespace stillpoint::sim
