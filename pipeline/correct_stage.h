/// Applies the calibration in force to each reading: u = H (y - B(T)).
#pragma once
#include "core/calibration.h"
#include "pipeline/guard_stage.h"

namespace stillpoint::pipeline {

class CorrectStage {
 public:
  using Input = GuardedSample;
  using Output = CalibratedSample;

  explicit CorrectStage(const CalibrationSnapshot& factory) noexcept : live_(factory), in_force_(factory) {}

  StageStatus process(const GuardedSample& in, CalibratedSample& out) noexcept {
    const RawSample& raw = in.sample;
    out = CalibratedSample{.t_ns = raw.t_ns,
                           .sequence = raw.sequence,
                           .acc_mps2 = array(in_force_.acc.apply(raw.acc_mps2, raw.temp_degC)),
                           .gyr_radps = array(in_force_.gyr.apply(raw.gyr_radps, raw.temp_degC)),
                           .mag_uT = array(in_force_.mag.apply(raw.mag_uT, raw.temp_degC)),
                           .temp_degC = raw.temp_degC,
                           .has = raw.has,
                           .acc_turn_rad = in.acc_turn_rad,
                           .mag_turn_rad = in.mag_turn_rad,
                           .clipped = in.clipped,
                           .absent = in.absent,
                           .calibration_version = live_.version};
    return in.clipped != 0 ? StageStatus::kDegraded : StageStatus::kOk;
  }

  void use(const CalibrationSnapshot& snapshot) noexcept {
    const TriadCalibration acc = is_known(snapshot.acc) ? snapshot.acc : in_force_.acc;
    live_ = in_force_ = snapshot;
    in_force_.acc = acc;
  }
  /// The last one.
  [[nodiscard]] const CalibrationSnapshot& live() const noexcept { return live_; }
  /// What readings are corrected by: of it, what is known.
  [[nodiscard]] const CalibrationSnapshot& in_force() const noexcept { return in_force_; }

 private:
  /// Of few attitudes the length of gravity is known, and how it divides between the axes is not: one window that a
  /// vehicle has pushed says 0.7 m/s^2 sideways, which would lean the attitude by as much.
  [[nodiscard]] static bool is_known(const TriadCalibration& acc) noexcept {
    return acc.status != CalibrationStatus::kTooFewWindows && acc.status != CalibrationStatus::kNotObservable;
  }

  CalibrationSnapshot live_, in_force_;
};

static_assert(Stage<CorrectStage>);

}  // namespace stillpoint::pipeline
