/// The middle and other shares of a list of numbers.
#pragma once
#include <algorithm>
#include <cstddef>
#include <vector>

namespace stillpoint {

/// Of an even count the upper of the two in the middle; 0 for none.
template <class T>
[[nodiscard]] T median(std::vector<T> v) {
  if (v.empty()) return T{};
  const auto middle = v.begin() + static_cast<std::ptrdiff_t>(v.size() / 2);
  std::nth_element(v.begin(), middle, v.end());
  return *middle;
}

/// The number that this share of the steps from the least to the largest lies at, rounded down; 0 for none.
[[nodiscard]] inline double quantile(std::vector<double> v, double share) {
  if (v.empty()) return 0.0;
  const auto at = v.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(v.size() - 1));
  std::nth_element(v.begin(), at, v.end());
  return *at;
}

}  // namespace stillpoint
