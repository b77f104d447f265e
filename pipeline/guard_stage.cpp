#include "pipeline/guard_stage.h"

#include <algorithm>
#include <cmath>

namespace stillpoint::pipeline {
namespace {

/// A reading a thousand times beyond full scale is a broken transfer, not a measurement.
constexpr double kAbsurd = 1e3;
/// Without a gyroscope reading for so many accelerometer readings, and overdue besides, the accelerometer leads.
constexpr int kGyroscopeSilentRows = 8;
/// ... and for so long: sensors begin one after the other, and a device hands its readings on in blocks, which a busy
/// machine holds up. Readings of the gyroscope behind one that led would be lost.
constexpr std::int64_t kGyroscopeAwaited_ns = 100'000'000;
/// Of the usual gap: a gyroscope that misses a few readings still leads.
constexpr double kSilentOverGap = 4.0;
/// A row of its own that lies further ahead is on another clock, or the sensor that leads is silent.
constexpr std::int64_t kFurthestAhead_ns = 1'000'000'000;

bool usable(const Array3& reading, double limit) noexcept {
  return std::all_of(reading.begin(), reading.end(),
                     [limit](double x) { return std::isfinite(x) && std::abs(x) <= kAbsurd * limit; });
}

bool at_limit(const Array3& reading, double limit) noexcept {
  return std::any_of(reading.begin(), reading.end(), [limit](double x) { return std::abs(x) >= kClippedFrom * limit; });
}

}  // namespace

std::array<double, kSampleParts> GuardStage::usual_steps_s() const noexcept {
  std::array<double, kSampleParts> steps_s{};
  for (std::size_t k = 0; k < kSampleParts; ++k) steps_s[k] = 1e-9 * times_[k].usual_step_ns();
  return steps_s;
}

bool GuardStage::leads(const RawSample& in) noexcept {
  if (in.holds(kGyr)) {
    gyr_seen_ = true;
    rows_without_gyr_ = 0;
    return true;
  }
  if (!in.holds(kAcc) || !SensorClock::is_time(in.t_ns)) return false;
  if (rows_without_gyr_ == 0 || in.t_ns < silent_since_ns_) silent_since_ns_ = in.t_ns;
  rows_without_gyr_ = std::min(rows_without_gyr_ + 1, kGyroscopeSilentRows + 1);
  if (in.t_ns - silent_since_ns_ < kGyroscopeAwaited_ns) return false;
  return !gyr_seen_ ||
         (rows_without_gyr_ > kGyroscopeSilentRows &&
          times_[part_index(kGyr)].overdue(clock_.in_pipeline_time(in.t_ns), kSilentOverGap * params_.gap_factor));
}

bool GuardStage::take_time(const RawSample& in, GuardedSample& out) noexcept {
  if (out.leads) {
    SensorClock::Step step;
    if (!clock_.advance(in.t_ns, params_.gap_factor, params_.clock_step_s, step)) {
      refuse_time();
      return false;
    }
    if (step.clock_was_set) ++counts_.clock_steps;
    counts_.longest_gap_ns = std::max(counts_.longest_gap_ns, step.gap_ns);
    out.after_gap = out.after_gap || step.gap;
    out.sample.t_ns = step.t_ns;
    return true;
  }
  if (!SensorClock::is_time(in.t_ns)) {
    refuse_time();
    return false;
  }
  out.sample.t_ns = clock_.in_pipeline_time(in.t_ns);
  const std::int64_t behind_ns = clock_.started() ? clock_.last_ns() - out.sample.t_ns : 0;
  if (behind_ns >= static_cast<std::int64_t>(1e9 * params_.late_s) + 1) {
    ++counts_.late;
    return false;
  }
  if (-behind_ns > kFurthestAhead_ns) {
    ++counts_.refused;
    return false;
  }
  for (const SamplePart part : {kAcc, kMag})
    if (in.holds(part) && !times_[part_index(part)].follows(out.sample.t_ns)) {
      refuse_time();
      return false;
    }
  return true;
}

void GuardStage::take_out_unusable(GuardedSample& out) noexcept {
  RawSample& sample = out.sample;
  const auto take_out = [&sample](SamplePart part, Array3& reading) {
    sample.has = static_cast<std::uint8_t>(sample.has & ~part);
    reading = {};
  };
  if (out.after_gap)
    for (SpikeGate* gate : {&acc_spikes_, &gyr_spikes_, &mag_spikes_}) gate->forget();
  const auto inspect = [&](SamplePart part, Array3& reading, double limit, SpikeGate& gate) {
    if (!sample.holds(part)) return;
    if (!usable(reading, limit)) {
      take_out(part, reading);
      ++counts_.not_finite;
    } else if (gate.refuses(reading)) {
      take_out(part, reading);
      out.spikes = static_cast<std::uint8_t>(out.spikes | part);
      ++counts_.spikes;
    } else if (at_limit(reading, limit)) {
      out.clipped = static_cast<std::uint8_t>(out.clipped | part);
    }
  };
  inspect(kAcc, sample.acc_mps2, params_.acc_limit_mps2, acc_spikes_);
  inspect(kGyr, sample.gyr_radps, params_.gyr_limit_radps, gyr_spikes_);
  inspect(kMag, sample.mag_uT, params_.mag_limit_uT, mag_spikes_);
}

/// The calibration depends on temperature: between two readings of a slow thermometer the last one holds.
void GuardStage::take_temperature(RawSample& sample) noexcept {
  if (sample.holds(kTemp) && !(std::abs(sample.temp_degC) < 500.0)) {
    sample.has = static_cast<std::uint8_t>(sample.has & ~kTemp);
    ++counts_.not_finite;
  }
  if (sample.holds(kTemp)) {
    temp_degC_ = sample.temp_degC;
    temp_known_ = temp_fresh_ = true;
  }
  sample.temp_degC = temp_degC_;
}

void GuardStage::note_readings(const RawSample& sample) noexcept {
  for (const SamplePart part : {kAcc, kGyr, kMag, kTemp}) {
    if (!sample.holds(part)) continue;
    times_[part_index(part)].note(sample.t_ns);
    ++counts_.readings[part_index(part)];
  }
}

std::uint8_t GuardStage::absent_at(std::int64_t t_ns) const noexcept {
  unsigned absent = 0;
  for (const SamplePart part : {kAcc, kGyr, kMag, kTemp}) {
    const ReadingTimes& times = times_[part_index(part)];
    if (!times.seen() || times.overdue(t_ns, params_.gap_factor)) absent |= part;
  }
  return static_cast<std::uint8_t>(absent);
}

StageStatus GuardStage::process(const RawSample& in, GuardedSample& out) noexcept {
  const bool jumped = started_ && in.sequence > last_sequence_ + 1;
  if (jumped) counts_.lost += in.sequence - last_sequence_ - 1;
  last_sequence_ = in.sequence;
  started_ = true;
  if (in.has == 0) return StageStatus::kDrop;  // nothing was measured: a row of a reference, say
  ++counts_.rows;
  out = GuardedSample{.sample = in};
  out.leads = leads(in);
  out.after_gap = jumped;
  if (out.leads) ++counts_.samples;
  if (!take_time(in, out)) return StageStatus::kDrop;
  take_out_unusable(out);
  take_temperature(out.sample);
  note_readings(out.sample);
  if (!holds_triad(out.sample)) {
    if ((in.has & (kAcc | kGyr | kMag)) != 0) ++counts_.refused;
    return StageStatus::kDrop;
  }
  if (out.clipped != 0) ++counts_.clipped;
  if (!out.leads) return StageStatus::kOk;
  if (out.after_gap) ++counts_.gaps;
  if (temp_fresh_) out.sample.has = static_cast<std::uint8_t>(out.sample.has | kTemp);
  temp_fresh_ = false;
  out.absent = absent_at(out.sample.t_ns);
  clock_.keep(in.t_ns, out.sample.t_ns);
  return out.after_gap || out.clipped != 0 || out.sample.has != in.has ? StageStatus::kDegraded : StageStatus::kOk;
}

}  // namespace stillpoint::pipeline
