/// The highest point of a function with one top.
#pragma once

namespace stillpoint::diag {

/// Golden section on [low, high]: each of the `sections` leaves 0.618 of the interval, at one more value of `f`.
template <class F>
[[nodiscard]] double highest_by_golden_section(double low, double high, int sections, const F& f) {
  constexpr double kGolden = 0.6180339887498949;
  double a = high - kGolden * (high - low), b = low + kGolden * (high - low);
  double at_a = f(a), at_b = f(b);
  for (int i = 0; i < sections; ++i) {
    if (at_a > at_b) {
      high = b, b = a, at_b = at_a, a = high - kGolden * (high - low), at_a = f(a);
    } else {
      low = a, a = b, at_a = at_b, b = low + kGolden * (high - low), at_b = f(b);
    }
  }
  return 0.5 * (low + high);
}

}  // namespace stillpoint::diag
