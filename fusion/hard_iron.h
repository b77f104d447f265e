/// Magnetism fixed to the sensor, learnt while it turns: a field that turns with the body is the body's, a field that
/// stays while the body turns is the place's. (A14)-(A16) of docs/math/attitude.md.
/// The linear form of Gebre-Egziabher et al., "Calibration of strapdown magnetometers in magnetic field domain" (2006),
/// with the attitude known from gyroscope and accelerometer, run as a Kalman filter so that both parts may change.
#pragma once
#include <optional>
#include <type_traits>

#include "core/fields.h"
#include "core/types.h"

namespace stillpoint::fusion {

struct HardIronParams {
  double sd_uT = 10.0;
  double unseen_sd_uT = 50.0;
  double walk_uT_rtHz = 0.02;
  double field_walk_uT_rtHz = 0.3;
  double noise_uT = 3.0;
  double noise_time_s = 1.0;
  double doubt = 12.0;

  template <class P = HardIronParams>
  static constexpr auto fields() {
    return std::tuple{
        field("sd_uT", &P::sd_uT, in_range(0.0, 1e4),
              "field of the body's own magnetism that the calibration may have left; 0: not learnt"),
        field("unseen_sd_uT", &P::unseen_sd_uT, in_range(0.0, 1e4),
              "the same before turns have shown it, as the heading's deviation states it: 50 for a magnetometer that "
              "nobody calibrated; equal to sd_uT for one that somebody did"),
        field("walk_uT_rtHz", &P::walk_uT_rtHz, in_range(0.0, 100.0), "random walk of that field"),
        field("field_walk_uT_rtHz", &P::field_walk_uT_rtHz, in_range(0.0, 100.0),
              "random walk of the field of the place, as seen by a sensor that moves through it"),
        field("noise_uT", &P::noise_uT, in_range(1e-3, 1e3),
              "deviation of one reading: noise and the unevenness of the place"),
        field("noise_time_s", &P::noise_time_s, in_range(0.0, 100.0), "time after which that deviation is another one"),
        field("doubt", &P::doubt, in_range(0.0, 1e6),
              "chi-square of three by which the body's field must differ from none before any of it is taken out")};
  }
};

/// Six states: the place's field m in world axes and the body's field h in body axes, R y = m + R h + noise.
class HardIron {
 public:
  void reset(const HardIronParams& params) noexcept;

  /// One mean over `time_s`: field_world_uT is the mean of R y, R_mean the mean of R. A reading that the model cannot
  /// explain (a magnet passes) is left out.
  void observe(const HardIronParams& params, const Vec3& field_world_uT, const Mat3& R_mean, double time_s) noexcept;

  /// (A16) The body's field (uT, body axes), shrunk by the doubt: an uneven place looks a little like iron on the body.
  /// After James and Stein, "Estimation with quadratic loss" (1961), positive part. Zero until the body has turned.
  [[nodiscard]] Vec3 body_uT(const HardIronParams& params) const noexcept;
  /// (A17) Mean square of what body_uT() leaves, uT^2: the uncertainty, and the share that the doubt holds back.
  [[nodiscard]] Mat3 left_uT2(const HardIronParams& params) const noexcept;
  /// (A17a) What comes to it, uT^2, where turns have not shown the iron and its prior may be wrong.
  [[nodiscard]] Mat3 unseen_uT2(const HardIronParams& params) const noexcept;

  /// (A18) Another finder's value lies outside what this one was told to expect, and what is taken out outside its
  /// covariance.
  [[nodiscard]] bool contradicted(const HardIronParams& params, const Vec3& body_uT,
                                  const Mat3& covariance_uT2) const noexcept;
  /// This sensor's iron has been found once; another one shows as a misfit first.
  [[nodiscard]] bool settled() const noexcept { return settled_; }
  /// Starts over from that value.
  void begin_at(const HardIronParams& params, const Vec3& body_uT, const Mat3& covariance_uT2) noexcept;

  /// (A14) The calibration has changed: readings u become K u + c. `calibrated_uT2` is the calibration's own covariance
  /// of the offset that remains, none where it has learnt none. Whoever knows the offset better states it from here on;
  /// the evidence of the other is dropped, so none counts twice.
  void rebase(const Mat3& K, const Vec3& c, const std::optional<Mat3>& calibrated_uT2) noexcept;

 private:
  [[nodiscard]] Mat3 body_covariance() const noexcept;

  Array3 place_{};
  Array3 body_{};
  std::array<double, 36> p_{};
  double misfit_s_ = 0.0;  ///< time for which the model has failed
  bool started_ = false;
  bool settled_ = false;
};

static_assert(std::is_trivially_copyable_v<HardIron>);

}  // namespace stillpoint::fusion
