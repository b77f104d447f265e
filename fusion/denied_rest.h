/// A rest that the gyroscope denies: gravity decides. Carried along by rates that are not there, gravity wanders off in
/// the filter's world just as they say; carried by true ones it stays.
#pragma once
#include <array>
#include <cmath>
#include <type_traits>

#include "core/types.h"
#include "core/units.h"

namespace stillpoint::fusion {

/// Regression of the horizontal force (m/s^2, world axes of the filter) on what the rates alone would make of gravity
/// there; plain state, a few operations a period. Nothing is said of a turn about the vertical.
class DeniedRest {
 public:
  /// Means over the period that has just passed.
  void note(const Vec3& force_world_mps2, const Vec3& rate_world_radps, double time_s) noexcept {
    predicted_mps2_[0] += kStandardGravity_mps2 * rate_world_radps.y() * time_s;
    predicted_mps2_[1] -= kStandardGravity_mps2 * rate_world_radps.x() * time_s;
    count_ += 1.0;
    for (std::size_t i = 0; i < 2; ++i) {
      const double p = predicted_mps2_[i], o = force_world_mps2[static_cast<int>(i)];
      sum_p_[i] += p, sum_o_[i] += o, sum_pp_ += p * p, sum_po_ += p * o, sum_oo_ += o * o;
    }
  }

  /// Gravity moves as only wrong rates could make it, and its own scatter does not explain that.
  [[nodiscard]] bool denies_gyroscope() const noexcept {
    if (count_ < kFewest) return false;
    double pp = sum_pp_, po = sum_po_, oo = sum_oo_;
    for (std::size_t i = 0; i < 2; ++i) {
      pp -= sum_p_[i] * sum_p_[i] / count_;
      po -= sum_p_[i] * sum_o_[i] / count_;
      oo -= sum_o_[i] * sum_o_[i] / count_;
    }
    if (!(pp > 0.0)) return false;
    const double share = po / pp, left2 = std::fmax(oo - share * po, 0.0) / (2.0 * count_ - 3.0);
    return share > kMostly && share * share * pp > kSure * kSure * left2;
  }

 private:
  static constexpr double kFewest = 6.0;  ///< periods
  static constexpr double kMostly = 0.5;  ///< of what the rates predict; 1 where all of them is wrong
  static constexpr double kSure = 5.0;    ///< standard deviations
  std::array<double, 2> predicted_mps2_{}, sum_p_{}, sum_o_{};
  double count_ = 0.0, sum_pp_ = 0.0, sum_po_ = 0.0, sum_oo_ = 0.0;
};

static_assert(std::is_trivially_copyable_v<DeniedRest>);

}  // namespace stillpoint::fusion
