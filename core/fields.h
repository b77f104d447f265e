/// A parameter struct lists its fields once; YAML reading, --print-config and the reference page all use that list.
/// The list is a template, so that only those who ask for it pay for its types: that was a third of the compilation of
/// every file that knows the stages.
#pragma once
#include <limits>
#include <string_view>
#include <tuple>

namespace stillpoint {

/// Closed interval a number must lie in. NaN never does.
struct Range {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  [[nodiscard]] constexpr bool holds(double x) const noexcept { return x >= low && x <= high; }
};
constexpr Range in_range(double low, double high) { return {low, high}; }
constexpr Range positive() { return {std::numeric_limits<double>::min(), std::numeric_limits<double>::max()}; }
constexpr Range finite() { return {std::numeric_limits<double>::lowest(), std::numeric_limits<double>::max()}; }

/// One field of struct P. The range applies to numbers and to each element of arrays and vectors.
template <class P, class T>
struct Field {
  std::string_view name;  ///< the key, with its unit as suffix
  T P::*member;
  Range range;
  std::string_view help;
};

template <class P, class T>
constexpr Field<P, T> field(std::string_view name, T P::*member, Range range, std::string_view help) {
  return {name, member, range, help};
}
template <class P, class T>
constexpr Field<P, T> field(std::string_view name, T P::*member, std::string_view help) {
  return {name, member, finite(), help};
}

template <class P>
concept HasFields = requires {
  P::fields();
};

}  // namespace stillpoint
