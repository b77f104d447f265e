/// The covariance of the filter's error state: propagation over many samples at once and scalar updates.
/// (A4)-(A7) of docs/math/attitude.md.
#pragma once
#include <array>
#include <cmath>
#include <type_traits>

#include "core/types.h"
#include "fusion/jump_evidence.h"
#include "fusion/pull.h"

namespace stillpoint::fusion {

/// Where each error stands in the error state. Rotation, velocity, position: world axes; the others: body axes.
/// The rotation error is global: R_true = exp(theta) R_estimated.
enum ErrorIndex : int {
  kTheta = 0,         ///< rad
  kVelocity = 3,      ///< m/s
  kPosition = 6,      ///< m
  kGyrBias = 9,       ///< rad/s
  kAccBias = 12,      ///< m/s^2
  kGyrMatrix = 15,    ///< 9 elements, column by column: the rate is (I - M) u - b
  kDisturbance = 24,  ///< rad, deviation of the magnetic heading by the place
  kErrorStates = 25,
};

using ErrorVector = Eigen::Matrix<double, kErrorStates, 1>;
using ErrorMatrix = Eigen::Matrix<double, kErrorStates, kErrorStates>;
/// What P does not hold. Of an untrue hard iron: three columns times its error (uT, body axes), and one of its own. Of
/// the gyroscope's matrix: nine times the part of its error that the filter does not learn.
constexpr int kOfIron = 4, kOfGyrMatrix = 9;
using UntoldMatrix = Eigen::Matrix<double, kErrorStates, kOfIron + kOfGyrMatrix, Eigen::RowMajor>;
/// What each jump of jump_evidence.h, if it has been, has done to the errors: three columns times its size.
using JumpMatrix = Eigen::Matrix<double, kErrorStates, 3 * kJumps, Eigen::RowMajor>;

/// What the samples between two covariance steps leave behind. Plain sums, so the cost per sample is small.
struct MotionSums {
  double time_s = 0.0;
  Array9 R{};                      ///< sum of R_world_body dt
  std::array<Array9, 3> R_rate{};  ///< sum of R_world_body u_j dt, u the corrected rate, for each j
  Array3 force{};                  ///< sum of the world specific force dt, m/s
};

/// Power densities of the noises that drive the errors; zero for a part that does not walk.
struct ProcessNoise {
  Array9 theta_rad2{};              ///< already integrated over the step
  Array9 velocity_m2ps2{};          ///< already integrated over the step
  double gyr_bias_walk = 0.0;       ///< rad/s/sqrt(s)
  double acc_bias_walk = 0.0;       ///< m/s^2/sqrt(s)
  double disturbance_rad = 0.0;     ///< stationary standard deviation
  double disturbance_time_s = 1.0;  ///< correlation time
};

class ErrorState {
 public:
  [[nodiscard]] Eigen::Map<const ErrorMatrix> P() const noexcept { return Eigen::Map<const ErrorMatrix>(p_.data()); }
  [[nodiscard]] Eigen::Map<ErrorMatrix> P() noexcept { return Eigen::Map<ErrorMatrix>(p_.data()); }
  [[nodiscard]] Eigen::Map<const ErrorVector> mean() const noexcept {
    return Eigen::Map<const ErrorVector>(mean_.data());
  }

  /// (A17) error = what P holds + S (error of the hard iron) + r. S is the first three columns; r, the fourth, is what
  /// an iron that has been found since had done before.
  [[nodiscard]] auto by_iron() const noexcept { return untold().leftCols<kOfIron>(); }
  [[nodiscard]] auto by_iron() noexcept { return untold().leftCols<kOfIron>(); }

  /// (A34) error = what P holds + S (unlearnt error of the gyroscope's matrix): variance of the rotation, world axes,
  /// for these variances of its elements.
  [[nodiscard]] Mat3 unlearnt_rad2(const Array9& variances) const noexcept;
  /// Of one element of it: what P holds, and its own part of the variance that is not learnt.
  [[nodiscard]] double gyr_matrix_variance(int element, double unlearnt2) const noexcept;
  /// It is now known from elsewhere: its error with that variance. What the unlearnt part has done to the other errors
  /// is learnt with it.
  void learn_gyr_matrix(int element, double error, double variance, double unlearnt2) noexcept;

  /// (A27) A jump of the three errors from `first` on that would begin now; what was said of this one before is void.
  void begin_jump(int jump, int first) noexcept;
  [[nodiscard]] const JumpEvidence& jump_evidence(int jump) const noexcept {
    return evidence_[static_cast<std::size_t>(jump)];
  }
  /// What it does to the rotation: columns per unit of its size.
  [[nodiscard]] Mat3 turned_by_jump(int jump) const noexcept { return by_jump().block<3, 3>(kTheta, 3 * jump); }
  /// It has been, of this size and covariance.
  void believe_jump(int jump, const Vec3& size, const Mat3& covariance) noexcept;

  [[nodiscard]] const Pull& pull() const noexcept { return pull_; }
  [[nodiscard]] Pull& pull() noexcept { return pull_; }

  /// Variance of the tilt, rad^2: about both horizontal axes.
  [[nodiscard]] double tilt_rad2() const noexcept { return P()(kTheta, kTheta) + P()(kTheta + 1, kTheta + 1); }

  /// Variance of the gyroscope's offset, per axis: the mean of the three.
  [[nodiscard]] double gyr_bias_rad2ps2() const noexcept { return P().diagonal().segment<3>(kGyrBias).mean(); }

  /// Independent errors with these standard deviations.
  void start(const ErrorVector& sd) noexcept;

  /// (A5) P <- F P F' + Q over the interval of the sums.
  void propagate(const MotionSums& sums, const ProcessNoise& noise) noexcept;

  /// The hard iron that is taken out has changed by this much.
  void change_iron(const Vec3& change_uT) noexcept { by_iron().col(3) += by_iron().leftCols<3>() * change_uT; }
  /// Variance of the rotation, world axes, that P does not hold; `left_uT2` is the mean square of the iron's error.
  [[nodiscard]] Mat3 iron_rad2(const Mat3& left_uT2) const noexcept;

  /// (A7) One scalar measurement z = h' x + iron' (error of the hard iron) + noise. The mean gathers the correction
  /// until take_mean(). A row that is not finite changes nothing. `taught`, 0 to 1, scales the gain of each error
  /// (A31): what the measurement itself errs by would be taken for theirs. One that may not teach the gyroscope's
  /// offset does not tell of jumps either.
  void update(const ErrorVector& h, double z, double variance, const Vec3& iron = Vec3::Zero(),
              const ErrorVector& taught = ErrorVector::Ones()) noexcept;
  /// The same for z = x(index) + noise.
  void update(int index, double z, double variance) noexcept;
  /// The same with the gain that `limit` leaves of the optimal one (Joseph's form): what is not to be learnt of it.
  template <class Limit>
  void update(int index, double z, double variance, const Limit& limit) noexcept {
    const Innovation v = innovation(index, z, variance);
    if (!v.usable()) return;
    const ErrorVector Ph = P().col(index);
    ErrorVector gain = Ph / v.variance;
    limit(gain);
    correct_in_part(gain, Ph, v);
    weigh_jumps(v);
  }

  /// Adds variance to one error; what was known of its correlations stays.
  void add_variance(int index, double variance) noexcept {
    P()(index, index) += variance;
    if (index < kVelocity) pull_.doubt(index, variance);
  }
  /// Adds variance to tilt and level velocity together: `share` of the squares of errors that would go with one
  /// another.
  void add_lean(double share, const Eigen::Vector2d& tilt_rad, const Eigen::Vector2d& velocity_mps) noexcept;
  /// Forgets one error: its variance is set and its correlations are dropped. What a jump has done to it stays.
  void forget(int index, double variance) noexcept;

  /// Makes one error, so far independent, depend on others: x(index) += weights' x. Pre: weights(index) = 0.
  void depend(int index, const ErrorVector& weights) noexcept;

  /// The world axes are turned: rotation, velocity and position are expressed anew.
  void turn_world(const Mat3& by) noexcept;

  /// Time runs the other way from here: velocity and gyro bias change their sign.
  void turn_back() noexcept;

  /// The correction gathered since the last call; the mean is zero afterwards.
  [[nodiscard]] ErrorVector take_mean() noexcept;

 private:
  /// An innovation, its variance, and its own dependence on the hard iron and on the jumps.
  struct Innovation {
    double value, variance;
    Eigen::Matrix<double, 1, kOfIron + kOfGyrMatrix> untold;
    Eigen::Matrix<double, 1, 3 * kJumps> by_jump;
    [[nodiscard]] bool usable() const noexcept { return variance > 0.0 && std::isfinite(value * variance); }
  };
  /// Of x(index) + noise.
  [[nodiscard]] Innovation innovation(int index, double z, double variance) const noexcept;
  void correct(const ErrorVector& gain, const ErrorVector& Ph, const Innovation& v) noexcept;
  /// By any gain, not only the optimal one (Joseph's form).
  void correct_in_part(const ErrorVector& gain, const ErrorVector& Ph, const Innovation& v) noexcept;
  void weigh_jumps(const Innovation& v) noexcept;
  [[nodiscard]] Eigen::Map<const UntoldMatrix> untold() const noexcept {
    return Eigen::Map<const UntoldMatrix>(untold_.data());
  }
  [[nodiscard]] Eigen::Map<UntoldMatrix> untold() noexcept { return Eigen::Map<UntoldMatrix>(untold_.data()); }
  [[nodiscard]] auto by_gyr_matrix() const noexcept { return untold().rightCols<kOfGyrMatrix>(); }
  [[nodiscard]] auto by_gyr_matrix() noexcept { return untold().rightCols<kOfGyrMatrix>(); }
  [[nodiscard]] Eigen::Map<const JumpMatrix> by_jump() const noexcept {
    return Eigen::Map<const JumpMatrix>(by_jump_.data());
  }
  [[nodiscard]] Eigen::Map<JumpMatrix> by_jump() noexcept { return Eigen::Map<JumpMatrix>(by_jump_.data()); }
  std::array<double, kErrorStates * kErrorStates> p_{};
  std::array<double, kErrorStates> mean_{};
  std::array<double, kErrorStates*(kOfIron + kOfGyrMatrix)> untold_{};
  std::array<double, kErrorStates * 3 * kJumps> by_jump_{};
  std::array<JumpEvidence, kJumps> evidence_{};
  Pull pull_;
};

static_assert(std::is_trivially_copyable_v<ErrorState>);

}  // namespace stillpoint::fusion
