/// Temperature-tagged forgetting: one vector of moment sums per temperature cell. Evidence fades only when newer
/// evidence of the same temperature arrives, so coming back to 5 degC finds what was learnt at 5 degC
/// (docs/math/temperature.md, T8-T10). The alternative to the Kalman form of temperature_filter.h; which is the
/// default, and why, says docs/decisions/011.
#pragma once
#include <array>

#include "calib_online/ellipsoid_fit.h"
#include "core/fields.h"

namespace stillpoint::calib {

struct TemperatureCellsParams {
  double first_degC = 0.0;
  double spacing_K = 5.0;
  double kernel_K = 1.5;
  double keep = 0.998;

  static constexpr auto fields() {
    using P = TemperatureCellsParams;
    return std::tuple{
        field("first_degC", &P::first_degC, in_range(-100.0, 100.0), "temperature of the first of eleven cells"),
        field("spacing_K", &P::spacing_K, in_range(0.5, 50.0),
              "between cells; colder and warmer falls into the first and last"),
        field("kernel_K", &P::kernel_K, in_range(0.5, 100.0), "how far evidence of one temperature serves another"),
        field("keep", &P::keep, in_range(0.5, 1.0), "what a new window leaves of its cell's older evidence"),
    };
  }
};

class TemperatureCells {
 public:
  static constexpr int kCells = 11;
  using State = std::array<Moments, kCells>;
  static_assert(sizeof(State) <= 3100, "what one sensor may cost with temperature");

  explicit TemperatureCells(const TemperatureCellsParams& params = {}) : params_(params) {}

  /// x in working coordinates, C the covariance of its noise there.
  void add(const Vec3& x, const Mat3& C, double temp_degC, double weight = 1.0) noexcept;
  /// The sums that serve at this temperature: of all cells, each weighted by its distance.
  [[nodiscard]] Moments near(double temp_degC) const noexcept;
  /// The sums of all cells: no temperature model at all.
  [[nodiscard]] Moments all() const noexcept;

  [[nodiscard]] const State& state() const noexcept { return cells_; }
  void restore(const State& state) noexcept { cells_ = state; }

 private:
  TemperatureCellsParams params_;
  State cells_{};
};

}  // namespace stillpoint::calib
