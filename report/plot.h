/// What a plot of a page shows; report/plots.js draws it.
#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace stillpoint::report {

/// The page's colours; each has a light and a dark value.
enum class Colour : std::uint8_t { kBefore, kAfter, kNoise, kAccent };
/// Of a sensor's x, y and z.
inline constexpr std::array<Colour, 3> kAxisColour{Colour::kBefore, Colour::kAfter, Colour::kAccent};

enum class Mark : std::uint8_t { kLine, kBold, kDashed, kDots };

/// One value for each x of its plot; not a number where there is none.
struct Curve {
  std::string label;
  Colour colour = Colour::kAccent;
  std::vector<double> y;
  Mark mark = Mark::kLine;
};

struct Plot {
  std::string id;  ///< of its place in the page
  std::string x_label, y_label;
  std::vector<double> x;  ///< ascending where a curve is a line
  std::vector<Curve> curves;
  std::vector<bool> shaded{};  ///< for each x; empty: nothing
  bool log_x = false, log_y = false;
};

/// The same with x ascending, for a law over a driver that goes up and down.
[[nodiscard]] Plot in_order_of_x(Plot plot);

}  // namespace stillpoint::report
