/// Takes known physics out of the corrected readings: the `compensate:` block of the configuration, in the words of the
/// effect catalogue (docs/configuration.md). A corrected reading is u = true + delta; this stage subtracts delta.
/// Rest windows are compensated too, before anything is learnt from them: otherwise the calibration would absorb the
/// same effect into its bias and it would be subtracted twice.
#pragma once
#include "calib_online/field_turns.h"
#include "calib_online/window.h"
#include "core/calibration.h"
#include "pipeline/laws_taken_out.h"
#include "pipeline/stage.h"

namespace stillpoint::pipeline {

/// Coefficients of u = true + delta, in the sensor's frame. All zero: nothing is changed, bit for bit.
struct Compensation {
  double temp_ref_degC = 25.0;
  Vec3 acc_per_K = Vec3::Zero(), acc_per_K2 = Vec3::Zero();  ///< acc_temp_lin, acc_temp_quad
  Vec3 acc_asym = Vec3::Zero();                              ///< delta = k |f|
  Vec3 acc_quad = Vec3::Zero();                              ///< delta = k f^2, 1/(m/s^2)
  Vec3 acc_cubic = Vec3::Zero();                             ///< delta = k f^3, 1/(m/s^2)^2
  Vec3 acc_lever_m = Vec3::Zero();                           ///< delta = dw/dt x r + w x (w x r)
  Vec3 gyr_per_K = Vec3::Zero(), gyr_per_K2 = Vec3::Zero();
  Mat3 gyr_gsens = Mat3::Zero();  ///< delta = G f, rad/s per m/s^2
  Vec3 gyr_asym = Vec3::Zero();
  Vec3 gyr_cubic = Vec3::Zero();  ///< (rad/s)^-2
  Vec3 mag_per_K = Vec3::Zero();  ///< uT/K
  double mag_delay_s = 0.0;       ///< the field is that of so long ago
  TakenOutLaws laws{};            ///< outside the catalogue
  bool any = false;               ///< false: the stage passes samples through
};

class CompensateStage {
 public:
  using Input = CalibratedSample;
  using Output = CalibratedSample;

  explicit CompensateStage(const Compensation& compensation = {}) : c_(compensation) {}
  StageStatus process(const CalibratedSample& in, CalibratedSample& out) noexcept;

  /// The window's raw means without the effects that show at rest. `live` is the calibration in force.
  void compensate(calib::Window& window, const CalibrationSnapshot& live) const noexcept;
  /// The same for a turn of the field.
  void compensate(calib::FieldTurn& turn, const CalibrationSnapshot& live) const noexcept;

 private:
  [[nodiscard]] Vec3 true_force(const Vec3& u, double tau_K) const noexcept;
  [[nodiscard]] Vec3 true_rate(const Vec3& u, const Vec3& force, double tau_K) const noexcept;
  [[nodiscard]] Vec3 lever(const Vec3& rate, std::int64_t t_ns) noexcept;

  void take_out_laws(CalibratedSample& sample) noexcept;

  Compensation c_;
  Momentary last_read_;             ///< before the laws: bridges samples without one of the sensors
  Vec3 last_force_ = Vec3::Zero();  ///< at the sensor: bridges samples without an accelerometer reading
  Vec3 last_rate_ = Vec3::Zero();
  std::int64_t last_rate_ns_ = 0;
  bool has_rate_ = false;
};

static_assert(Stage<CompensateStage>);

}  // namespace stillpoint::pipeline
