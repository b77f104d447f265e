#include "pipeline/guard_stage.h"

#include <algorithm>
#include <cmath>

namespace stillpoint::pipeline {
namespace {

/// So many samples in a row that advance among themselves, all behind the last one let through: the clock was set back.
constexpr int kBackwardRun = 8;
/// A reading a thousand times beyond full scale is a broken transfer, not a measurement.
constexpr double kAbsurd = 1e3;
/// 126 years either way: the difference of two such times fits into 64 bits, a time beyond is none.
constexpr std::int64_t kLargestTime_ns = 4'000'000'000'000'000'000;

bool usable(const Array3& reading, double limit) noexcept {
  return std::all_of(reading.begin(), reading.end(),
                     [limit](double x) { return std::isfinite(x) && std::abs(x) <= kAbsurd * limit; });
}

bool at_limit(const Array3& reading, double limit) noexcept {
  return std::any_of(reading.begin(), reading.end(), [limit](double x) { return std::abs(x) >= kClippedFrom * limit; });
}

}  // namespace

void GuardStage::learn_step(std::int64_t step_ns) noexcept {
  const auto step = static_cast<double>(step_ns);
  // A running median: moves by a fixed share towards each step, so single gaps hardly count.
  if (usual_step_ns_ == 0.0)
    usual_step_ns_ = step;
  else
    usual_step_ns_ *= step > usual_step_ns_ ? 1.02 : 1.0 / 1.02;
}

bool GuardStage::advance(std::int64_t sensor_ns, std::int64_t& t_ns, bool& gap) noexcept {
  if (sensor_ns > kLargestTime_ns || sensor_ns < -kLargestTime_ns || last_ns_ > kLargestTime_ns) return false;
  t_ns = sensor_ns;
  if (!started_) return true;
  std::int64_t step = sensor_ns - last_sensor_ns_;
  const auto one_step = std::max<std::int64_t>(1, static_cast<std::int64_t>(usual_step_ns_));
  if (step <= 0) {
    const bool follows = backward_run_ > 0 && sensor_ns > backward_last_ns_;
    backward_run_ = follows ? backward_run_ + 1 : 1;
    backward_last_ns_ = sensor_ns;
    if (backward_run_ < kBackwardRun) return false;
    // What was refused meanwhile took time; the gap that remains is what the filter must bridge.
    step = kBackwardRun * one_step;
  } else if (static_cast<double>(step) > 1e9 * params_.clock_step_s) {
    step = one_step;
  } else {
    backward_run_ = 0;
    t_ns = last_ns_ + step;
    gap = usual_step_ns_ > 0.0 && static_cast<double>(step) > params_.gap_factor * usual_step_ns_;
    if (gap) counts_.longest_gap_ns = std::max(counts_.longest_gap_ns, step);
    learn_step(step);
    return true;
  }
  ++counts_.clock_steps;
  backward_run_ = 0;
  gap = true;
  last_sensor_ns_ = sensor_ns - step;  // on its new time base
  t_ns = last_ns_ + step;
  return true;
}

StageStatus GuardStage::process(const RawSample& in, GuardedSample& out) noexcept {
  ++counts_.samples;
  bool gap = false;
  std::int64_t t_ns = 0;
  if (!advance(in.t_ns, t_ns, gap)) {
    ++counts_.refused;
    return StageStatus::kDrop;
  }
  out = GuardedSample{in, 0, gap};
  RawSample& sample = out.sample;
  sample.t_ns = t_ns;
  const auto inspect = [&](SamplePart part, Array3& reading, double limit) {
    if (!sample.holds(part)) return;
    if (!usable(reading, limit)) {
      sample.has = static_cast<std::uint8_t>(sample.has & ~part);
      reading = {};
      ++counts_.not_finite;
    } else if (at_limit(reading, limit)) {
      out.clipped = static_cast<std::uint8_t>(out.clipped | part);
    }
  };
  inspect(kAcc, sample.acc_mps2, params_.acc_limit_mps2);
  inspect(kGyr, sample.gyr_radps, params_.gyr_limit_radps);
  inspect(kMag, sample.mag_uT, params_.mag_limit_uT);
  if (sample.holds(kTemp) && !(std::abs(sample.temp_degC) < 500.0)) {
    sample.has = static_cast<std::uint8_t>(sample.has & ~kTemp);
    ++counts_.not_finite;
  }
  // The calibration depends on temperature: between two readings of a slow thermometer the last one holds.
  if (sample.holds(kTemp)) {
    temp_degC_ = sample.temp_degC;
    temp_known_ = true;
  }
  sample.temp_degC = temp_degC_;

  if ((sample.has & (kAcc | kGyr | kMag)) == 0) {
    ++counts_.refused;
    return StageStatus::kDrop;
  }
  if (started_ && in.sequence > last_sequence_ + 1) {
    counts_.lost += in.sequence - last_sequence_ - 1;
    out.after_gap = true;
  }
  if (out.after_gap) ++counts_.gaps;
  if (out.clipped != 0) ++counts_.clipped;
  last_ns_ = t_ns;
  last_sensor_ns_ = in.t_ns;
  last_sequence_ = in.sequence;
  started_ = true;
  return out.after_gap || out.clipped != 0 || sample.has != in.has ? StageStatus::kDegraded : StageStatus::kOk;
}

}  // namespace stillpoint::pipeline
