/// Temperature-tagged forgetting: one vector of moment sums per temperature cell. Evidence fades only when newer
/// evidence of the same temperature arrives, so coming back to 5 degC finds what was learnt at 5 degC
/// (docs/math/temperature.md, T9-T13). A cell with few directions inherits from the others: all cells lie about one
/// polynomial, and what that leaves makes a cell count less the further away it is. The alternative to the Kalman form
/// of temperature_filter.h; which is the default, and why, says docs/decisions/011.
#pragma once
#include <array>

#include "calib_online/moments.h"
#include "calib_online/quadric.h"
#include "core/fields.h"

namespace stillpoint::calib {

struct TemperatureCellsParams {
  double first_degC = 0.0;
  double spacing_K = 5.0;
  double alike_K = 10.0;
  double keep = 0.998;

  template <class P = TemperatureCellsParams>
  static constexpr auto fields() {
    return std::tuple{
        field("first_degC", &P::first_degC, in_range(-100.0, 100.0), "where the first of ten cells begins"),
        field("spacing_K", &P::spacing_K, in_range(0.5, 50.0),
              "width of a cell; colder and warmer falls into the first and last"),
        field("alike_K", &P::alike_K, in_range(0.5, 1000.0),
              "over this difference what the common polynomial leaves of the bias becomes another"),
        field("keep", &P::keep, in_range(0.5, 1.0), "what a new window leaves of its cell's older evidence"),
    };
  }
};

class TemperatureCells {
 public:
  static constexpr int kCells = 10;
  static constexpr int kTrend = 21;  ///< nine entries at tau = 0, nine slopes, three curvatures of the bias entries
  using Trend = Eigen::Matrix<double, kTrend, 1>;
  struct Cell {
    Moments sums;
    double temp_sum = 0.0;  ///< weighted as the sums are: a cell's evidence is that of its mean temperature
  };
  using State = std::array<Cell, kCells>;
  static_assert(sizeof(State) <= 3000, "what one sensor may cost with temperature");

  /// What is known beforehand, in the entries of d(x)^T p(tau) = 1, and how far a window's 1 - d^T p is off.
  struct Prior {
    Trend variance = Trend::Ones();  ///< about the unit sphere
    double temp_ref_degC = 25.0;
    double local_variance = 0.0;   ///< of a bias entry, about the polynomial
    double window_variance = 1.0;  ///< of 1 - d^T p in one window of weight one
  };
  struct Estimate {
    Vec9 p = Vec9::Zero();
    Mat9 covariance = Mat9::Zero();
    bool valid = false;
  };

  explicit TemperatureCells(const TemperatureCellsParams& params = {}) : params_(params) {}

  /// x in working coordinates, C the covariance of its noise there.
  void add(const Vec3& x, const Mat3& C, double temp_degC, double weight = 1.0) noexcept;
  /// The nine entries at this temperature, from all cells (T11-T13).
  [[nodiscard]] Estimate at(double temp_degC, const Prior& prior) const noexcept;
  /// The sums of all cells: no temperature model at all.
  [[nodiscard]] Moments all() const noexcept;

  [[nodiscard]] const State& state() const noexcept { return cells_; }
  void restore(const State& state) noexcept { cells_ = state; }

 private:
  TemperatureCellsParams params_;
  State cells_{};
};

}  // namespace stillpoint::calib
