/// What a pause of the gyroscope leaves unknown of the turn: learnt from how the rate of this very motion changes.
/// (A2a) of docs/math/attitude.md.
#pragma once
#include <array>
#include <type_traits>

#include "core/types.h"

namespace stillpoint::fusion {

/// The rate as a process that wanders: between two known ends it is off its straight line by a bridge.
class RateBridge {
 public:
  /// Mean rate of one period of the covariance.
  void observe(const Vec3& rate_radps, double time_s) noexcept;
  /// No rate is known for a while: differences do not span it.
  void interrupt() noexcept { filled_ = 0; }

  /// A step this long is a pause at the rate that samples have come lately.
  [[nodiscard]] bool is_pause(double step_s) const noexcept {
    return usual_step_s_ > 0.0 && step_s > 2.5 * usual_step_s_;
  }
  void note_step(double step_s) noexcept;
  [[nodiscard]] double usual_step_s() const noexcept { return usual_step_s_; }

  /// Covariance [rad^2, body axes] of the turn over `gap_s` when both ends of the rate are known: along the axes about
  /// which this body changes its rate, and a little about any.
  [[nodiscard]] Mat3 bridge_rad2(double gap_s) const noexcept;

 private:
  static constexpr std::size_t kLag = 4;
  std::array<Array3, kLag> rates_radps_{};
  std::size_t at_ = 0, filled_ = 0;
  double rate2_ = 0.0;            ///< mean square, rad^2/s^2
  std::array<double, 9> walk_{};  ///< second moment of the change per time, rad^2/s^3
  double usual_step_s_ = 0.0;
};

static_assert(std::is_trivially_copyable_v<RateBridge>);

}  // namespace stillpoint::fusion
