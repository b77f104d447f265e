/// Single readings that no motion gives: a bit lost on the bus, a broken transfer. One of 300 rad/s would turn the
/// attitude by 170 degrees in a hundredth of a second.
#pragma once
#include <algorithm>
#include <cmath>

#include "core/types.h"

namespace stillpoint::pipeline {

/// Of one triad. A step far beyond those that this sensor makes is not believed, until it has lasted.
class SpikeGate {
 public:
  /// \param smallest_step in the unit of the reading: what a knock may do from one sample to the next.
  explicit SpikeGate(double smallest_step) noexcept : smallest_step_(smallest_step) {}

  /// True: the reading is not to be used. Expects finite readings.
  [[nodiscard]] bool refuses(const Array3& reading) noexcept {
    double step = 0.0;
    for (std::size_t k = 0; k < 3; ++k) step = std::max(step, std::abs(reading[k] - last_[k]));
    if (started_ && refused_ < kMostInARow && step > std::max(smallest_step_, kFarBeyond * usual_step_)) {
      ++refused_;
      return true;
    }
    if (started_ && refused_ == 0) usual_step_ += kShare * (step - usual_step_);
    last_ = reading;
    started_ = true;
    refused_ = 0;
    return false;
  }

  /// Time has passed: any reading may follow.
  void forget() noexcept { started_ = false; }

 private:
  static constexpr double kFarBeyond = 20.0;
  static constexpr double kShare = 0.01;  ///< of one step in the usual one
  static constexpr int kMostInARow = 3;   ///< what lasts longer is the motion, or a fault with another name

  double smallest_step_, usual_step_ = 0.0;
  Array3 last_{};
  int refused_ = 0;
  bool started_ = false;
};

}  // namespace stillpoint::pipeline
