/// Numbers of rows of which a Fourier transform is fast: products of 2, 3 and 5 only. Of 56 381 rows, 13 times a prime,
/// it takes minutes.
#pragma once
#include <Eigen/Core>

namespace stillpoint::diag {

[[nodiscard]] constexpr bool is_fast_length(Eigen::Index n) {
  for (const Eigen::Index factor : {2, 3, 5})
    while (n > 1 && n % factor == 0) n /= factor;
  return n <= 1;
}

/// The fewest, at least so many.
[[nodiscard]] constexpr Eigen::Index fast_length_from(Eigen::Index n) {
  while (!is_fast_length(n)) ++n;
  return n;
}

/// The most, at most so many. At least 1.
[[nodiscard]] constexpr Eigen::Index fast_length_within(Eigen::Index n) {
  while (!is_fast_length(n)) --n;
  return n;
}

}  // namespace stillpoint::diag
