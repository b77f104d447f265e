#include "pipeline/assemble_stage.h"

#include <algorithm>

#include "core/so3.h"
#include "core/units.h"

namespace stillpoint::pipeline {
namespace {

constexpr std::int64_t kLongestStep_ns = 500'000'000;  ///< over a longer gap the last rate says nothing

}  // namespace

void AssembleStage::Waiting::push(const Reading& reading) noexcept {
  if (count == kMost) pop();
  readings[(first + count++) % kMost] = reading;
}

void AssembleStage::Waiting::pop() noexcept {
  first = (first + 1) % kMost;
  --count;
}

void AssembleStage::note_turn(const RawSample& sample) noexcept {
  if (turns_known_ > 0 && sample.t_ns - turns_[newest_].t_ns > kLongestStep_ns) {
    turns_known_ = 0;
    acc_.count = mag_.count = 0;
  }
  const Array3 rate = sample.holds(kGyr) || turns_known_ == 0 ? sample.gyr_radps : turns_[newest_].rate_radps;
  newest_ = (newest_ + 1) % kMost;
  turns_[newest_] = {sample.t_ns, rate};
  turns_known_ = std::min(turns_known_ + 1, kMost);
}

Vec3 AssembleStage::turned_since(std::int64_t from_ns, double temp_degC) const noexcept {
  Quat turned = Quat::Identity();
  for (std::size_t back = 0; back < turns_known_; ++back) {
    const Turn& step = turns_[(newest_ + kMost - back) % kMost];
    const bool oldest = back + 1 == turns_known_;
    const std::int64_t began_ns = oldest ? from_ns : turns_[(newest_ + kMost - back - 1) % kMost].t_ns;
    const double part_s = in_seconds(step.t_ns - std::max(from_ns, began_ns));
    const Vec3 phi = part_s * gyr_.apply(step.rate_radps, temp_degC);
    if (began_ns <= from_ns && back == 0) return phi;
    turned = exp_quat(phi) * turned;
    if (began_ns <= from_ns) break;
  }
  return log_quat(turned);
}

void AssembleStage::join(Waiting& waiting, SamplePart part, Array3& value, Array3& turn_rad,
                         GuardedSample& out) noexcept {
  Vec3 sum = Vec3::Zero(), turn = Vec3::Zero();
  int count = 0;
  for (; waiting.count > 0 && waiting.front().t_ns + late_ns_ <= out.sample.t_ns; waiting.pop()) {
    const Reading& reading = waiting.front();
    sum += vec(reading.value);
    turn += turned_since(reading.t_ns, out.sample.temp_degC);
    if (reading.clipped) out.clipped = static_cast<std::uint8_t>(out.clipped | part);
    ++count;
  }
  if (count == 0) return;
  if (out.sample.holds(part)) {
    sum += vec(value);
    ++count;
  }
  value = array(Vec3(sum / count));
  turn_rad = array(Vec3(turn / count));
  out.sample.has = static_cast<std::uint8_t>(out.sample.has | part);
}

StageStatus AssembleStage::process(const GuardedSample& in, GuardedSample& out) noexcept {
  if (!in.leads) {
    const RawSample& row = in.sample;
    if (row.holds(kAcc)) acc_.push({row.t_ns, row.acc_mps2, (in.clipped & kAcc) != 0});
    if (row.holds(kMag)) mag_.push({row.t_ns, row.mag_uT, (in.clipped & kMag) != 0});
    return StageStatus::kDrop;
  }
  out = in;
  note_turn(in.sample);
  join(acc_, kAcc, out.sample.acc_mps2, out.acc_turn_rad, out);
  join(mag_, kMag, out.sample.mag_uT, out.mag_turn_rad, out);
  return StageStatus::kOk;
}

}  // namespace stillpoint::pipeline
