/// How large errors are beside what was stated for them: what a sensor's evidence says of the noise that its model
/// assumes. It makes stated deviations grow while evidence contradicts, and shrink where the model was too careful.
#pragma once
#include <algorithm>
#include <cmath>

namespace stillpoint::calib {

struct Consistency {
  double chi2 = 0.0, freedom = 0.0;  ///< fading sums

  /// The squared error over its stated variance, and how many numbers it was of.
  void see(double value, double degrees) noexcept {
    constexpr double kMemory = 0.97, kMostOfOne = 9.0;
    chi2 = kMemory * chi2 + std::min(value, kMostOfOne * degrees);
    freedom = kMemory * freedom + degrees;
  }
  /// Times the assumed variance; one until there is evidence.
  [[nodiscard]] double variance_scale(double least) const noexcept {
    constexpr double kAssumed = 12.0;  // so much evidence the assumption is worth
    constexpr double kMost = 9.0;
    // Below one by logarithms: added, a hundredth could not bring the assumption below a tenth.
    const double scale = chi2 < freedom ? std::pow(chi2 / freedom, freedom / (freedom + kAssumed))
                                        : (chi2 + kAssumed) / (freedom + kAssumed);
    return std::clamp(scale, least, kMost);
  }
};

}  // namespace stillpoint::calib
