#include "pipeline/noise_watch.h"

#include <algorithm>
#include <cmath>

namespace stillpoint::pipeline {
namespace {

constexpr int kReadings = 24;       ///< of a part, at least: ten degrees of freedom
constexpr double kPart_s = 0.1;     ///< a stride, a stroke and a blow have calm moments of this length
constexpr double kLongest_s = 0.6;  ///< of a part: to a sensor below 40 Hz the strokes of a motion are noise
constexpr int kParts = 5;           ///< of a block
constexpr double kNoisier2 = 9.0;  ///< three times the deviation: the calmest part of 72 sound recordings stays below 1
constexpr double kAlike = 1.5;     ///< of two orders of differences; scatter of 120 readings, three deviations
constexpr double kSteady = 16.0;   ///< most over least of the parts: one block of a thousand has more
constexpr double kKnown_s = 10.0;  ///< under way, before anything is called usual
constexpr double kGotUsedTo_s = 60.0, kForgotten_s = 300.0;

bool alike(double a, double b) { return a < kAlike * b && b < kAlike * a; }

}  // namespace

void NoiseWatch::Orders::add(const Orders& o, double weight) noexcept {
  vec(second) += weight * vec(o.second);
  vec(third) += weight * vec(o.third);
  vec(fifth) += weight * vec(o.fifth);
}

void NoiseWatch::note(const Array3& reading, double dt_s, bool under_way) noexcept {
  if (!differences_.push(reading)) return;
  part_.add({differences_.noise2(2), differences_.noise2(3), differences_.noise2(5)}, 1.0);
  part_s_ += dt_s;
  block_.under_way |= under_way;
  if (++readings_ >= kReadings && part_s_ >= kPart_s) end_part();
}

void NoiseWatch::end_part() noexcept {
  if (part_s_ > kLongest_s) {
    part_ = {};
    block_ = {};
    part_s_ = excess_ = last_excess_ = 0.0;
    readings_ = 0;
    return;
  }
  const double share = 1.0 / readings_;
  for (std::size_t k = 0; k < 3; ++k) {
    const double noise2 = share * part_.third[k];
    block_.least2[k] = block_.parts == 0 ? noise2 : std::min(block_.least2[k], noise2);
    block_.most2[k] = std::max(block_.most2[k], noise2);
  }
  block_.sum.add(part_, share / kParts);
  block_.time_s += part_s_;
  part_ = {};
  part_s_ = 0.0;
  readings_ = 0;
  if (++block_.parts == kParts) end_block();
}

bool NoiseWatch::white(const Block& b, std::size_t k) const noexcept {
  return alike(b.sum.second[k], b.sum.third[k]) && alike(b.sum.fifth[k], b.sum.third[k]) &&
         b.most2[k] < kSteady * b.least2[k];
}

void NoiseWatch::end_block() noexcept {
  double now = 0.0;
  for (std::size_t k = 0; k < 3; ++k) {
    // Once told it is so until it is less, whatever the motion adds.
    const double over =
        excess_ > 1.0 || white(block_, k) ? block_.least2[k] / (kNoisier2 * std::max(usual2_[k], least2_)) : 0.0;
    now = std::max(now, over);
    const bool odd = over > 1.0 && known_s_ >= kKnown_s;  // it becomes usual if it lasts
    if (block_.least2[k] < usual2_[k])
      usual2_[k] -= std::min(1.0, block_.time_s / kForgotten_s) * (usual2_[k] - block_.least2[k]);
    else if (block_.under_way)
      usual2_[k] += (odd ? std::min(1.0, block_.time_s / kGotUsedTo_s) : 1.0) * (block_.least2[k] - usual2_[k]);
  }
  excess_ = known_s_ >= kKnown_s ? std::min(now, last_excess_) : 0.0;
  last_excess_ = now;
  if (block_.under_way) known_s_ += block_.time_s;
  block_ = {};
}

}  // namespace stillpoint::pipeline
