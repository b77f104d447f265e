/// The magnetometer's soft iron, mounting and hard iron from what its readings do in turns, as a Kalman filter in
/// constant memory (docs/math/field.md, F2-F7; the pairwise form is ours, its linear kernel that of alignment.h).
/// u = (I + D) w - c with w the factory-calibrated reading: D holds soft iron and the angles to the gyroscope's axes, c
/// the field that the body carries. A field fixed in the world drops out of every pair, however strong it is.
#pragma once
#include <array>
#include <optional>

#include "calib_online/field_turns.h"
#include "calib_online/temperature_filter.h"
#include "core/fields.h"

namespace stillpoint::calib {

struct FieldFilterParams {
  double soft_iron_sd = 0.05;
  double hard_iron_sd_uT = 50.0;
  double hard_iron_walk_uT_rts = 0.005;
  double place_uT = 1.0;
  double repeats = 50.0;
  double gyr_bias_sd_radps = 0.2 * kRadPerDeg;
  double gyr_matrix_sd = 0.018;

  template <class P = FieldFilterParams>
  static constexpr auto fields() {
    return std::tuple{
        field("soft_iron_sd", &P::soft_iron_sd, in_range(1e-4, 0.5),
              "sd of the factory calibration's matrix per element, mounting included"),
        field("hard_iron_sd_uT", &P::hard_iron_sd_uT, in_range(1e-2, 1e4), "sd of its bias"),
        field("hard_iron_walk_uT_rts", &P::hard_iron_walk_uT_rts, in_range(0.0, 10.0),
              "random walk of the field that the body carries, per root second"),
        field("place_uT", &P::place_uT, in_range(1e-2, 100.0),
              "unevenness of the field between two readings of a turn, before any was seen"),
        field("repeats", &P::repeats, in_range(1.0, 1e4),
              "turns in which the same unevenness and the same error of the gyro come again: so many count as one"),
        field("gyr_bias_sd_radps", &P::gyr_bias_sd_radps, in_range(0.0, 0.1),
              "what the rate is off in a turn, before the bias is learnt"),
        field("gyr_matrix_sd", &P::gyr_matrix_sd, in_range(0.0, 0.3),
              "what a turn is off, relative to its path, before the gyroscope's matrix is learnt"),
    };
  }
};

class FieldFilter {
 public:
  static constexpr int kStates = 12;  ///< rows of D, then c in uT
  using StateVec = Eigen::Matrix<double, kStates, 1>;
  using StateMat = Eigen::Matrix<double, kStates, kStates>;

  struct State {
    std::array<double, kStates> x{};
    Packed<kStates> P;
    double misfit_uT2 =
        0.0;  ///< of a pair, per axis, beyond its turn's and the states': noise and place, as seen lately
    double white_uT2 = 0.0;    ///< the part of it that is noise of the readings
    double strength_uT = 0.0;  ///< of the calibrated field, as seen lately
    /// Squared length of the pairs' misfits in uT^2, fading: by the factory calibration and by ours before each update.
    double factory_error = 0.0, learnt_error = 0.0;
    std::uint32_t pairs = 0, compared = 0;
    /// The misfits of lately, and what of them a change of the carried field would explain (F6).
    Array9 change_information{};
    Array3 change_rhs{};
    double change_energy = 0.0;
    std::uint32_t rejected_run = 0;
    std::uint32_t changes = 0;  ///< times that the carried field was found to have changed
  };

  explicit FieldFilter(const FieldFilterParams& params) : params_(params) { reset(); }

  void reset() noexcept;
  void predict(double dt_s) noexcept;

  enum class Verdict : std::uint8_t {
    kUsed,
    kWorldChanged,  ///< set aside: the field changed and not with the body
    kBodyChanged,   ///< set aside, and the carried field opened: what changed turns with the body
  };
  /// One turn of the field, in factory-calibrated readings: v_before = R v_after.
  struct Pair {
    Vec3 before_uT, after_uT;
    Mat3 R;
    double noise_uT2 = 0.0;  ///< per axis, of the difference
    double path_rad = 0.0, time_s = 0.0;
    double gyr_matrix_sd = 0.0;      ///< what a turn is off, relative to its path
    double gyr_bias_sd_radps = 0.0;  ///< and for its time; zero where nothing is known of the bias
  };
  Verdict update(const Pair& pair) noexcept;
  /// Squared length of what the states leave of a pair, without the share of its turn's own error, uT^2.
  [[nodiscard]] double misfit_uT2(const Pair& pair) const noexcept;
  /// Before any pair: what a pair is expected to be off for the place's sake, uT^2 per axis.
  void expect_misfit(double uT2) noexcept { s_.misfit_uT2 = uT2; }
  void count_each_pair() noexcept { params_.repeats = 1.0; }

  [[nodiscard]] Mat3 matrix() const noexcept;      ///< I + D
  [[nodiscard]] Vec3 carried_uT() const noexcept;  ///< c
  [[nodiscard]] Mat3 carried_covariance() const noexcept;
  /// Mean square over the sphere of the error of the calibrated field per axis, and where it is largest, uT^2.
  struct Uncertainty {
    double mean_uT2 = 0.0, worst_uT2 = 0.0, norm_uT2 = 0.0;
  };
  [[nodiscard]] Uncertainty uncertainty() const noexcept;
  /// (F7) Predicts pairs so much better than the factory calibration that the world cannot be the reason.
  [[nodiscard]] bool better_than_factory() const noexcept;
  /// Every direction is known.
  [[nodiscard]] bool observable() const noexcept;

  [[nodiscard]] const State& state() const noexcept { return s_; }
  void restore(const State& s) noexcept { s_ = s; }

 private:
  using Mat3x12 = Eigen::Matrix<double, 3, kStates>;
  [[nodiscard]] static Mat3x12 design(const Pair& pair, const Mat3& lever) noexcept;
  [[nodiscard]] Vec3 field_of(const Pair& pair) const noexcept;
  [[nodiscard]] Mat3 turned(const Pair& pair, const Vec3& field) const noexcept;
  void open_carried_field(const Vec3& change) noexcept;
  /// Squared lengths of what either calibration leaves of a pair, uT^2.
  void compare_with_factory(double factory_uT2, double learnt_uT2) noexcept;
  void note_misfit(const Vec3& e, const Mat3& lever, bool rejected) noexcept;
  /// Of the carried field, where it explains the misfits of lately.
  [[nodiscard]] std::optional<Vec3> change_of_body() const noexcept;

  FieldFilterParams params_;
  State s_;
};

}  // namespace stillpoint::calib
