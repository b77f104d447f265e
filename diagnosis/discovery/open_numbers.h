/// Numbers in the text of a law that it is as free in as in its coefficients: time constants, moments, thresholds.
#pragma once
#include <string>
#include <vector>

namespace stillpoint::diag {

/// Behind the comma of a function, or what an argument is divided by.
struct OpenNumber {
  std::string digits, name, unit;  ///< as in the text; "tau", "at", "threshold"; empty where the driver has the unit
};

/// Each once, though a moment may stand in a step and in what settles after it.
[[nodiscard]] std::vector<OpenNumber> open_numbers(const std::string& text);

/// Another number, or "{}", in the place of this one, wherever it stands.
[[nodiscard]] std::string with_number(std::string text, const std::string& digits, const std::string& other);

/// The text with "{}" for each of them: what laws have in common that differ in their numbers alone.
[[nodiscard]] std::string form_of(std::string text);

}  // namespace stillpoint::diag
