/// The gyroscope's matrix from gravity before and after the turns between windows (docs/math/gyro.md, Y6), as what is
/// published and a rival that turns may put in its place; and from turns of known angle (Y9).
#pragma once
#include <cmath>
#include <span>

#include "calib_online/consistency.h"
#include "calib_online/gyro_matrix.h"
#include "calib_online/known_turn.h"
#include "calib_online/rivalry.h"
#include "calib_online/window.h"
#include "core/calibration.h"
#include "core/fields.h"

namespace stillpoint::calib {

struct GyroMatrixParams {
  double scale_sd = 0.03;
  double cross_sd = 0.02;
  template <class P = GyroMatrixParams>
  static constexpr auto fields() {
    return std::tuple{
        field("scale_sd", &P::scale_sd, in_range(1e-6, 0.3), "sd of the factory calibration's scale factors"),
        field("cross_sd", &P::cross_sd, in_range(1e-6, 0.3), "sd of its axes' directions, rad")};
  }
};

/// How far from the factory calibration the matrix is looked for.
enum class MatrixPrior : std::uint32_t {
  kFactory,
  kWide,       ///< ten times as far: what is published was a rival
  kWideScale,  ///< the scales only: known turns said so. They see axes by their square only, so those stay as they were
};

class GyrMatrixLearner {
 public:
  struct State {
    GyroMatrixSums published, rival;
    Rivalry::State rivalry;
    Consistency noise;           ///< of turns beside what is assumed of them
    std::uint32_t wide = 0;      ///< the MatrixPrior of what is published
    std::uint32_t refused = 0;   ///< turns that what is published did not explain
    std::uint32_t in_a_row = 0;  ///< of them
    double lately = 1.0;         ///< chi-square of a number, fading fast: how the turns of now fit
    Array3 previous_acc_mps2{};
    double previous_temp_degC = 0.0;
    std::uint32_t has_previous = 0;
  };

  GyrMatrixLearner(const GyroMatrixParams& params, const TriadCalibration& factory, double bias_prior_sd_radps,
                   double gravity_mps2);

  /// A window of rest after a turn, judged by the calibration in force; what may push its direction aside, rad^2. True:
  /// the matrix changed.
  bool absorb(const Window& w, const CalibrationSnapshot& used, double pushed_var) noexcept;
  /// Turns of known angle, together, and before the turns of the same recording: those are linearised about what is
  /// published. True: the matrix changed.
  bool absorb(std::span<KnownTurn> turns) noexcept;
  /// The bias is another sensor's: the matrix may be, too.
  void sensor_replaced() noexcept;
  /// False: the turns give none.
  bool publish(TriadCalibration& gyr) noexcept;
  /// What is published, with its covariance.
  [[nodiscard]] const GyroMatrixFit& stated() const noexcept { return stated_; }
  /// Of what is published, rms over its elements.
  [[nodiscard]] double sd() const noexcept { return std::sqrt(stated_.covariance.trace() / 9.0); }

  [[nodiscard]] const State& state() const noexcept { return s_; }
  void restore(const State& s) noexcept;

 private:
  struct Turn;
  [[nodiscard]] GyroMatrixFit fit(const GyroMatrixSums& sums, MatrixPrior prior) const noexcept;
  [[nodiscard]] GyroMatrixFit published() const noexcept;
  [[nodiscard]] bool beyond_wide(const GyroMatrixFit& fit) const noexcept;
  void learn(const Turn& turn) noexcept;
  [[nodiscard]] KnownTurn* best_fit(std::span<KnownTurn> turns) const noexcept;
  [[nodiscard]] bool scales_doubted(std::span<const KnownTurn> turns) const noexcept;

  GyroMatrixParams params_;
  TriadCalibration factory_;
  double bias_prior_sd_radps_, gravity_mps2_;
  GyroMatrixFit stated_;
  Rivalry rivalry_;
  State s_;  ///< its rivalry is that of rivalry_
};

}  // namespace stillpoint::calib
