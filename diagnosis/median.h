/// The middle of a list of numbers.
#pragma once
#include <algorithm>
#include <cstddef>
#include <vector>

namespace stillpoint::diag {

/// Of an even count the upper of the two in the middle; 0 for none.
[[nodiscard]] inline double median(std::vector<double> v) {
  if (v.empty()) return 0.0;
  const auto middle = v.begin() + static_cast<std::ptrdiff_t>(v.size() / 2);
  std::nth_element(v.begin(), middle, v.end());
  return *middle;
}

}  // namespace stillpoint::diag
