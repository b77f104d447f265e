/// The default temperature model: calibration parameters that are polynomials of temperature with a slowly decaying
/// part for hysteresis, as Kalman filters over rest windows (docs/math/temperature.md, T1-T8; the design is ours, in
/// neither paper). tau = (T - T_ref) / 25 K.
#pragma once
#include <array>

#include "calib_online/quadric.h"
#include "calib_online/window.h"
#include "core/fields.h"
#include "core/units.h"

namespace stillpoint::calib {

inline constexpr double kTempScale_K = 25.0;

/// A symmetric matrix of size N as its lower triangle, row by row.
template <int N>
struct Packed {
  std::array<double, static_cast<std::size_t>(N*(N + 1) / 2)> a{};
  [[nodiscard]] Eigen::Matrix<double, N, N> full() const noexcept {
    Eigen::Matrix<double, N, N> m;
    std::size_t k = 0;
    for (int i = 0; i < N; ++i)
      for (int j = 0; j <= i; ++j) m(i, j) = m(j, i) = a[k++];
    return m;
  }
  void set(const Eigen::Matrix<double, N, N>& m) noexcept {
    std::size_t k = 0;
    for (int i = 0; i < N; ++i)
      for (int j = 0; j <= i; ++j) a[k++] = m(i, j);
  }
};

struct AccFilterParams {
  double bias_sd_mps2 = 0.3;
  double scale_sd = 0.01;
  double shear_sd = 0.01;
  double bias_per_K_sd_mps2 = 0.008;
  double bias_curvature_sd_mps2 = 0.08;
  double matrix_per_25K_sd = 0.003;
  double wander_sd_mps2 = 0.02;
  double wander_s = 3600.0;
  double bias_walk_mps2_rts = 1e-5;
  double norm_floor_mps2 = 0.005;

  template <class P = AccFilterParams>
  static constexpr auto fields() {
    return std::tuple{
        field("bias_sd_mps2", &P::bias_sd_mps2, in_range(1e-4, 10.0), "sd of the factory calibration's bias"),
        field("scale_sd", &P::scale_sd, in_range(1e-5, 0.3), "sd of its scale factors"),
        field("shear_sd", &P::shear_sd, in_range(1e-5, 0.3), "sd of the angles between its axes, rad"),
        field("bias_per_K_sd_mps2", &P::bias_per_K_sd_mps2, in_range(0.0, 1.0),
              "sd of the bias slope over temperature"),
        field("bias_curvature_sd_mps2", &P::bias_curvature_sd_mps2, in_range(0.0, 10.0),
              "sd of its curvature, at 25 K"),
        field("matrix_per_25K_sd", &P::matrix_per_25K_sd, in_range(0.0, 0.3),
              "sd of what 25 K do to an element of the matrix"),
        field("wander_sd_mps2", &P::wander_sd_mps2, in_range(0.0, 1.0), "hysteresis and slow wander of the bias"),
        field("wander_s", &P::wander_s, in_range(1.0, 1e7), "time after which that is forgotten"),
        field("bias_walk_mps2_rts", &P::bias_walk_mps2_rts, in_range(0.0, 0.1),
              "random walk of the bias, per root second"),
        field("norm_floor_mps2", &P::norm_floor_mps2, in_range(1e-5, 1.0),
              "what a window's norm is off beyond its noise"),
    };
  }
};

/// d(x)^T p(tau) = 1 with d = (x^2, y^2, z^2, xy, xz, yz, x, y, z): 9 at tau = 0, 9 slopes, 3 curvatures of the
/// bias entries, 3 decaying. Readings enter as x = factory-calibrated specific force over g, so the prior is the unit
/// sphere.
class AccFilter {
 public:
  static constexpr int kStates = 24;

  using StateVec = Eigen::Matrix<double, kStates, 1>;
  struct State {
    std::array<double, kStates> x{};
    Packed<kStates> P;
  };
  static_assert(sizeof(State) <= 3072, "what one sensor may cost with temperature");

  explicit AccFilter(const AccFilterParams& params, double gravity_mps2);

  void predict(double dt_s) noexcept;
  /// What a window of direction x at tau would say: (1 - h^T x, its variance without measurement noise).
  struct Innovation {
    double value = 0.0, variance = 0.0;
  };
  [[nodiscard]] Innovation innovation(const Vec3& x, double tau) const noexcept;
  /// Scalar update with the variance of the innovation's measurement part.
  void update(const Vec3& x, double tau, double variance) noexcept;
  /// What is known may be another: by as much as the prior says, and by so much of the norm, in scale and bias.
  void open(double relative) noexcept;
  void reset() noexcept;

  /// The nine entries and their covariance at tau.
  [[nodiscard]] Vec9 at(double tau) const noexcept;
  [[nodiscard]] Mat9 covariance_at(double tau) const noexcept;
  [[nodiscard]] Mat9 prior_covariance_at(double tau) const noexcept;
  /// Of each state before anything is learnt.
  [[nodiscard]] StateVec prior_variance() const noexcept;

  [[nodiscard]] const State& state() const noexcept { return s_; }
  void restore(const State& s) noexcept { s_ = s; }

 private:
  AccFilterParams params_;
  double gravity_mps2_;
  State s_;
};

struct GyrFilterParams {
  double bias_sd_radps = 1.0 * kRadPerDeg;
  double bias_per_K_sd_radps = 0.03 * kRadPerDeg;
  double bias_curvature_sd_radps = 0.2 * kRadPerDeg;
  double wander_sd_radps = 0.02 * kRadPerDeg;
  double wander_s = 3600.0;
  double bias_walk_radps_rts = 2e-6;
  double mean_floor_radps = 0.003 * kRadPerDeg;
  double hysteresis_per_K_radps = 0.004 * kRadPerDeg;

  template <class P = GyrFilterParams>
  static constexpr auto fields() {
    return std::tuple{
        field("bias_sd_radps", &P::bias_sd_radps, in_range(1e-6, 1.0), "sd of the factory calibration's bias"),
        field("bias_per_K_sd_radps", &P::bias_per_K_sd_radps, in_range(0.0, 0.1),
              "sd of the bias slope over temperature"),
        field("bias_curvature_sd_radps", &P::bias_curvature_sd_radps, in_range(0.0, 1.0),
              "sd of its curvature, at 25 K"),
        field("wander_sd_radps", &P::wander_sd_radps, in_range(0.0, 0.1), "hysteresis and slow wander of the bias"),
        field("wander_s", &P::wander_s, in_range(1.0, 1e7), "time after which that is forgotten"),
        field("bias_walk_radps_rts", &P::bias_walk_radps_rts, in_range(0.0, 0.01), "random walk, per root second"),
        field("mean_floor_radps", &P::mean_floor_radps, in_range(1e-8, 0.01),
              "what a window's mean is off beyond its noise"),
        field("hysteresis_per_K_radps", &P::hysteresis_per_K_radps, in_range(0.0, 0.1),
              "what a change of temperature leaves of the bias when it is undone, sd per K of the change"),
    };
  }
};

/// Bias over the factory's, per axis b0 + tau b1 + tau^2 b2 + decaying part; states (b0 b1 b2 w) of x, then y, then z,
/// then the rate at which the body may turn in its present attitude.
class GyrFilter {
 public:
  static constexpr int kBias = 12;
  static constexpr int kStates = kBias + 3;
  using StateVec = Eigen::Matrix<double, kStates, 1>;
  using StateMat = Eigen::Matrix<double, kStates, kStates>;
  struct State {
    std::array<double, kStates> x{};
    Packed<kStates> P;
  };

  explicit GyrFilter(const GyrFilterParams& params);
  void predict(double dt_s) noexcept;
  /// The body lies in another attitude: whatever turn hides there is another one, with this covariance.
  void begin_attitude(const Mat3& turn_covariance) noexcept;
  /// The constant part may be another by so much.
  void open_bias(double sd_radps) noexcept;
  /// A mean rate of rest with its covariance; tau and tau^2 as means over the stretch.
  void update(const Vec3& rate, const Mat3& covariance, double tau, double tau2) noexcept;
  void reset() noexcept;
  [[nodiscard]] Vec3 at(double tau, double tau2) const noexcept;
  [[nodiscard]] Mat3 covariance_at(double tau, double tau2) const noexcept;
  /// (b0 + decaying part, b1, b2) as columns.
  [[nodiscard]] Mat3 polynomial() const noexcept;
  /// Per axis: what temperature is seen to do between two tau is more than 2 sd of hysteresis and of its own error
  /// (T8). Less may belong to the sweep it was seen on and not to the temperature.
  [[nodiscard]] std::array<bool, 3> follows_temperature(double tau_min, double tau_max) const noexcept;
  [[nodiscard]] const State& state() const noexcept { return s_; }
  void restore(const State& s) noexcept { s_ = s; }

 private:
  /// Of the bias; those of a rate have the turn beside it.
  [[nodiscard]] static Eigen::Matrix<double, kStates, 3> regressors(double tau, double tau2) noexcept;
  [[nodiscard]] StateVec prior_variance() const noexcept;
  GyrFilterParams params_;
  State s_;
};

}  // namespace stillpoint::calib
