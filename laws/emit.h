/// Laws as code to paste into somebody else's simulator: a function of the drivers' columns that gives what the law
/// adds to the three axes. The code needs nothing but the language itself.
#pragma once
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "laws/expression.h"

namespace stillpoint::laws {

/// A free function of one number, an axis each: between points the cubic that has the slopes there, beyond them the end
/// value.
struct Table {
  std::vector<double> x;
  std::array<std::vector<double>, 3> y, slope;
};

/// What a law adds to a sensor: k times its number (axis by axis), or its vector axis by axis; or a matrix times it; or
/// what a table makes of it.
struct Coupled {
  Node tree;  ///< checked
  std::optional<Table> table;
  bool has_matrix = false;
  std::array<double, 9> matrix{};   ///< row-major; without a matrix the first three are k
  double from_s = 0.0, to_s = 0.0;  ///< of the law's time; equal: always
  std::string sensor, unit;         ///< for the comment: "accelerometer", "m/s^2"
  std::vector<std::string> beside;  ///< further lines of it: what it was found beside
};

enum class Language { kPython, kCpp, kMatlab };

/// "py", "h", "m"
[[nodiscard]] const char* suffix(Language language);

/// The function `name`(t, drivers in the order of drivers_of without t). Python and MATLAB take lists or columns
/// (vectors: n x 3), C++ std::vector<double> and std::vector<std::array<double, 3>>; times increase.
[[nodiscard]] std::string emit(const Coupled& law, const std::string& name, Language language);

}  // namespace stillpoint::laws
