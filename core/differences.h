/// Differences from reading to reading, and of those again: what a smooth motion leaves of them shrinks with the order,
/// while white noise keeps its size.
#pragma once
#include <array>
#include <cstddef>

#include "core/types.h"

namespace stillpoint {

/// Readings at even steps. Plain state, `Order` subtractions an axis.
template <std::size_t Order>
class Differences {
 public:
  /// False while there are too few readings for the highest order.
  bool push(const Array3& reading) noexcept {
    Array3 above = reading;
    for (std::size_t n = 0; n < Order; ++n) {
      const Array3 below = last_[n];
      last_[n] = above;
      if (n >= readings_) break;
      for (std::size_t k = 0; k < 3; ++k) above[k] -= below[k];
      of_order_[n] = above;
    }
    const bool enough = readings_ >= Order;
    if (!enough) ++readings_;
    return enough;
  }
  /// What comes next is not connected with what was: a gap.
  void interrupt() noexcept { readings_ = 0; }

  /// Of the last reading, squared, over what white noise of variance 1 has on average: C(2n, n). 1 <= n <= Order.
  [[nodiscard]] Array3 noise2(std::size_t n) const noexcept {
    double expected = 1.0;
    for (std::size_t j = 1; j <= n; ++j) expected *= static_cast<double>(n + j) / static_cast<double>(j);
    Array3 out{};
    for (std::size_t k = 0; k < 3; ++k) out[k] = of_order_[n - 1][k] * of_order_[n - 1][k] / expected;
    return out;
  }

 private:
  std::array<Array3, Order> last_{}, of_order_{};
  std::size_t readings_ = 0;
};

}  // namespace stillpoint
