/// What the sensors read beside what a reference predicts, row by row and with no model but gravity and the field:
/// enough to tell conventions, units and clocks apart, far too coarse to see physics.
#pragma once
#include <cmath>
#include <functional>
#include <optional>
#include <string>

#include "diagnosis/forensics/forensics.h"

namespace stillpoint::diag::detail {

/// Takes the four columns of the reference to Hamilton, body to world, ENU.
using Convention = std::function<Quat(const Eigen::Vector4d&)>;
[[nodiscard]] Quat as_expected(const Eigen::Vector4d& wxyz);

/// How one three-vector goes with another over many rows: y ~ size * Q x.
struct Relation {
  Mat3 product = Mat3::Zero();  ///< sum of x y'
  Vec3 x_sum = Vec3::Zero(), y_sum = Vec3::Zero();
  double xx = 0.0, yy = 0.0;
  std::size_t rows = 0;

  void add(const Vec3& x, const Vec3& y) {
    product += x * y.transpose();
    x_sum += x, y_sum += y;
    xx += x.squaredNorm(), yy += y.squaredNorm();
    ++rows;
  }
  /// The same of the deviations from the means: without what an offset adds.
  [[nodiscard]] Relation about_means() const;
  [[nodiscard]] double slope() const { return xx > 0 ? product.trace() / xx : 0.0; }
  [[nodiscard]] double correlation() const { return xx > 0 && yy > 0 ? product.trace() / std::sqrt(xx * yy) : 0.0; }
  /// The orthogonal map from y to x (a reflection allowed), in the sense of least squares.
  [[nodiscard]] Mat3 turn() const;
  /// Correlation after that map; its other half, whether the vectors came from more than one plane.
  [[nodiscard]] double coherence() const;
  [[nodiscard]] bool spans_space() const;
};

class Comparison {
 public:
  Comparison(const io::Recording& recording, const sim::SimulationConfig& config);

  /// Median angle between measured and predicted specific force; negative when there is nothing to compare. Without
  /// the position only moments near 1 g are used: they show which way is up.
  [[nodiscard]] double force_angle(const Convention& to_enu, bool with_position) const;
  /// The same between the measured field and the simulation's.
  [[nodiscard]] double field_angle() const;
  /// Share of the measured rate explained by the reference's, 1 - residual/total over the moving rows, in the quarter
  /// of the recording where it is highest: a wrong convention is wrong everywhere, lost samples only after the loss.
  [[nodiscard]] double rate_agreement(const Convention& to_enu) const;

  /// Predicted (x) and measured (y) vectors of one sensor.
  [[nodiscard]] Relation relation(Sensor s) const;
  /// The rates, as means over about 0.1 s: a noisy camera does not hide a wrong unit in them.
  [[nodiscard]] Relation slow_rates() const;
  /// The field as the sensor sees it, in the world of the reference; none with fewer than 100 rows.
  [[nodiscard]] std::optional<Vec3> field_in_world() const;

  bool force(std::size_t row, const Convention& to_enu, bool with_position, Vec3& measured, Vec3& predicted) const;
  bool rate(std::size_t row, const Convention& to_enu, Vec3& measured, Vec3& predicted) const;
  bool field(std::size_t row, Vec3& measured, Vec3& predicted) const;

  [[nodiscard]] std::size_t first() const { return stencil_; }
  [[nodiscard]] std::size_t stride() const { return stride_; }

 private:
  template <class F>
  void each_row(F&& f) const {
    for (std::size_t i = stencil_; i + stencil_ < r_.size(); i += stride_) f(i);
  }
  /// H (y - B) of the row; false where the sensor or its reading is not there.
  bool corrected(std::size_t row, Sensor s, Vec3& out) const;

  const io::Recording& r_;
  const sim::SimulationConfig& config_;
  double step_s_ = 0.0;
  std::size_t stencil_ = 1, stride_ = 1;
};

/// "body x is sensor -y, ..." when the map is nearly a signed permutation other than the identity; empty otherwise.
[[nodiscard]] std::string axes_in_words(const Mat3& turn, const char* to = "body", const char* from = "sensor");

}  // namespace stillpoint::diag::detail
