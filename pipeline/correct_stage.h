/// Applies the calibration in force to each reading: u = H (y - B(T)).
#pragma once
#include "core/calibration.h"
#include "pipeline/guard_stage.h"

namespace stillpoint::pipeline {

class CorrectStage {
 public:
  using Input = GuardedSample;
  using Output = CalibratedSample;

  explicit CorrectStage(const CalibrationSnapshot& factory) noexcept : live_(factory) {}

  StageStatus process(const GuardedSample& in, CalibratedSample& out) noexcept {
    const RawSample& raw = in.sample;
    out = CalibratedSample{.t_ns = raw.t_ns,
                           .sequence = raw.sequence,
                           .acc_mps2 = array(live_.acc.apply(raw.acc_mps2, raw.temp_degC)),
                           .gyr_radps = array(live_.gyr.apply(raw.gyr_radps, raw.temp_degC)),
                           .mag_uT = array(live_.mag.apply(raw.mag_uT, raw.temp_degC)),
                           .temp_degC = raw.temp_degC,
                           .has = raw.has,
                           .acc_turn_rad = in.acc_turn_rad,
                           .mag_turn_rad = in.mag_turn_rad,
                           .clipped = in.clipped,
                           .absent = in.absent,
                           .calibration_version = live_.version};
    return in.clipped != 0 ? StageStatus::kDegraded : StageStatus::kOk;
  }

  void use(const CalibrationSnapshot& snapshot) noexcept { live_ = snapshot; }
  [[nodiscard]] const CalibrationSnapshot& live() const noexcept { return live_; }

 private:
  CalibrationSnapshot live_;
};

static_assert(Stage<CorrectStage>);

}  // namespace stillpoint::pipeline
