/// One hypothesis about the gyroscope's bias: a filter over stretches of rest, with the stretch that is not over. A
/// stretch is one measurement: a turn that gravity and the field do not show is one unknown of it (docs/math/rest.md,
/// R6).
#pragma once
#include "calib_online/consistency.h"
#include "calib_online/rivalry.h"
#include "calib_online/temperature_filter.h"
#include "calib_online/window.h"

namespace stillpoint::calib {

/// A rate at rest, factory-calibrated, with all that may be in it beside the bias.
struct RestRate {
  Vec3 rate_radps = Vec3::Zero();
  Mat3 covariance = Mat3::Zero(), turn_covariance = Mat3::Zero();
  Vec3 rounding_var = Vec3::Zero();
  Vec3 up_body = Vec3::UnitZ();
  double direction_sd = 0.0;  ///< rad, of up in the body
  double tau = 0.0, temp_degC = 25.0;
  std::int64_t t_ns = 0;
};

/// Rates of rest in one attitude, as one mean.
struct Stretch {
  std::uint32_t windows = 0;
  std::uint32_t of_attitude = 0;  ///< stretches of this attitude before it: they share the turn that may hide in it
  std::int64_t start_ns = 0;
  double tau = 0.0, tau2 = 0.0, temp_degC = 0.0, direction_sd = 0.0;
  Array3 rate{}, up{}, rounding_var{};
  Array9 covariance{}, turn_covariance{};

  void add(const RestRate& r) noexcept;
  [[nodiscard]] bool same_attitude(const RestRate& r) const noexcept;
  /// The axis about which neither gravity nor the field shows a turn; zero where they show all.
  [[nodiscard]] Vec3 unseen_axis() const noexcept;
  /// What may hide in it: a turn about the unseen axis as assumed, about the others as the noise is.
  [[nodiscard]] Mat3 turn(double noise_scale) const noexcept;
  /// Of the mean, the turn apart.
  [[nodiscard]] Mat3 mean_covariance(double noise_scale) const noexcept;
};

/// What a stretch is off, rad/s, and the covariance of that; about an axis that nothing shows it is without bound.
struct StretchError {
  Vec3 value = Vec3::Zero();
  Mat3 covariance = Mat3::Zero();
  double known = 0.0;  ///< mean variance, the axis that nothing shows apart
};

class GyrHypothesis {
 public:
  struct State {
    GyrFilter::State filter;  ///< with the stretch that is not over: where the body is after a restart nobody knows
    std::uint32_t windows = 0;
    Consistency noise;  ///< of rates at rest beside what is assumed of them
  };

  explicit GyrHypothesis(const GyrFilterParams& params) : params_(params), filter_(params) {}

  void predict(double dt_s) noexcept;
  /// Ends the stretch where this reading cannot belong to it: moved, too late, another temperature.
  void separate(const RestRate& r, bool moved) noexcept;
  /// Of one reading, with the present stretch known.
  [[nodiscard]] Fit fit(const RestRate& r) const noexcept;
  /// Of the whole present stretch, by what was known before it; a turn about an axis that nothing shows says nothing.
  [[nodiscard]] StretchError error_of_stretch(const Stretch& s) const noexcept;
  [[nodiscard]] Fit fit_of_stretch(const Stretch& s) const noexcept;
  void take(const RestRate& r) noexcept {
    stretch_.add(r);
    ++windows_;
  }
  /// How well a whole attitude agrees with what was known before it. False: it says nothing of that.
  bool see(const Stretch& attitude, double gate) noexcept;
  /// A turn was seen: the stretch it began in is no rest. How many windows that were.
  std::uint32_t discard_stretch() noexcept;
  /// What is known with the stretch that is not over.
  [[nodiscard]] GyrFilter now() const noexcept;
  /// Its constant part may be another by so much.
  void open_bias(double sd_radps) noexcept { filter_.open_bias(sd_radps); }
  /// It may be another sensor's: that the one before agreed is no evidence of it.
  void forget_agreement() noexcept { noise_ = {}; }

  [[nodiscard]] const Stretch& stretch() const noexcept { return stretch_; }
  [[nodiscard]] std::uint32_t windows() const noexcept { return windows_; }
  [[nodiscard]] State state() const noexcept { return {now().state(), windows_, noise_}; }
  void restore(const State& s) noexcept;

 private:
  void commit() noexcept;
  [[nodiscard]] double noise_scale() const noexcept;

  GyrFilterParams params_;
  GyrFilter filter_;  ///< before the present stretch
  Stretch stretch_;
  Consistency noise_;
  std::uint32_t windows_ = 0;
};

}  // namespace stillpoint::calib
