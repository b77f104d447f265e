/// Rates that another program drew as straight lines between two readings: no sensor is as quiet.
#pragma once
#include <algorithm>
#include <type_traits>

#include "core/types.h"

namespace stillpoint::fusion {

/// Follows the line from where it began; plain state, a few operations a sample.
class StraightLine {
 public:
  void note(const Array3& reading, double dt_s) noexcept {
    const Vec3 expected = vec(last_) + (time_s_ > 0.0 ? dt_s / time_s_ : 0.0) * (vec(last_) - vec(first_));
    if (time_s_ > 0.0 && (vec(reading) - expected).cwiseAbs().maxCoeff() > kRounding_radps) {
      first_ = last_;
      time_s_ = 0.0;
      rows_ = 0;
    }
    time_s_ += dt_s;
    ++rows_;
    last_ = reading;
  }
  /// The present reading lies on a line that rises. A level one is a sensor that repeats itself, and judged as such.
  [[nodiscard]] bool drawn() const noexcept {
    return rows_ >= kFewest && time_s_ > kShortest_s &&
           (vec(last_) - vec(first_)).cwiseAbs().maxCoeff() > kFewest * kRounding_radps;
  }

 private:
  static constexpr double kRounding_radps = 3e-5;  ///< of a file with five decimals; noise is a hundred times as large
  static constexpr double kShortest_s = 0.1;
  static constexpr int kFewest = 8;
  Array3 first_{}, last_{};
  double time_s_ = 0.0;
  int rows_ = 0;
};

static_assert(std::is_trivially_copyable_v<StraightLine>);

}  // namespace stillpoint::fusion
