/// The noise of one sensor's residual: per axis an autoregression, with a scale that may change every two seconds,
/// apart for rest and motion where the reference is noisy (at rest nothing moves, so the reference's noise is not in
/// the residual). Whitening with it is what keeps every later statistic honest.
#pragma once
#include <vector>

#include "diagnosis/reference/signals.h"

namespace stillpoint::diag {

inline constexpr int kAutoregressiveOrder = 16;
inline constexpr double kScaleBlock_s = 2.0;

/// A run of samples [begin, end) under one regime.
struct Segment {
  Eigen::Index begin = 0, end = 0;
  int regime = 0;
};

/// Which samples count, and under which regime.
struct Layout {
  Eigen::Index n = 0;
  std::vector<Segment> segments;
  Eigen::ArrayXd counts;   ///< 1: the whitened sample is used, 0: not (muted, or its history is)
  Eigen::ArrayXd present;  ///< 1: the raw sample is valid
  int regimes = 1;
  int order = kAutoregressiveOrder;
  bool shortened = false;    ///< the order, for the holes
  Eigen::Index block = 100;  ///< samples of one scale block
  [[nodiscard]] double used() const { return counts.sum(); }
};

[[nodiscard]] Layout make_layout(const Signals& s, Sensor sensor);

/// The same without the blocks in which more than noise is left over: for a noise model of what lies between them. No
/// block is left out of a leftover that is alike throughout.
[[nodiscard]] Layout without_bursts(const Layout& layout, const Series3& leftover);

class NoiseModel {
 public:
  /// Fitted to what a model leaves over (n x 3).
  NoiseModel(const Layout& layout, const Series3& leftover);

  /// Applies the filter and the scale of one axis; samples that do not count become 0.
  [[nodiscard]] Series whiten(const Layout& layout, const Eigen::Ref<const Series>& x, int axis) const;
  /// What `whiten` multiplies the filtered samples of one axis with: 0 where they do not count.
  /// An expression: it lives as long as the layout and this.
  [[nodiscard]] auto scale(const Layout& layout, int axis) const {
    return (inverse_scale_.col(axis).array() * layout.counts).matrix();
  }
  /// Of the filter x_i - sum_j a_j x_{i-j-1}, j = 0..order - 1.
  [[nodiscard]] const Eigen::VectorXd& coefficients(int regime, int axis) const {
    return coefficients_[static_cast<std::size_t>(regime)][static_cast<std::size_t>(axis)];
  }
  /// The reverse for white draws of unit variance: noise with this colour and scale. Where nothing is measured it runs
  /// on.
  [[nodiscard]] Series coloured(const Layout& layout, const Series& white, int axis) const;
  /// One-sided power density at the given frequencies, unit^2/Hz; the regimes weigh as long as they last.
  [[nodiscard]] Series density(const Layout& layout, const Series& frequency_hz, double dt_s, int axis) const;
  /// Sum of -log(scale) over the samples that count: the part of the log-likelihood that is not in the whitened
  /// residual.
  [[nodiscard]] double log_scale_sum() const { return log_scale_sum_; }
  /// rms of the innovations of one axis, unit of the sensor.
  [[nodiscard]] double innovation_sd(int axis) const { return innovation_sd_[static_cast<std::size_t>(axis)]; }

 private:
  [[nodiscard]] Series filter(const Layout& layout, const Eigen::Ref<const Series>& x, int axis) const;
  std::array<std::array<Eigen::VectorXd, 3>, 2> coefficients_;  ///< [regime][axis]
  std::array<std::array<double, 3>, 2> variance_{};             ///< of the innovations, [regime][axis]
  Series3 inverse_scale_;
  double log_scale_sum_ = 0.0;
  std::array<double, 3> innovation_sd_{};
};

}  // namespace stillpoint::diag
