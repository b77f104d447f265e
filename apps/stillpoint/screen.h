/// What a terminal of 80 columns shows: lines that are cut, words in colour, curves of one line.
#pragma once
#include <string>
#include <string_view>
#include <vector>

namespace stillpoint::app {

/// A control character: io::printable() leaves none in what comes from files or the wire.
enum class Colour : char { kGood = '\1', kWarn = '\2', kBad = '\3' };

[[nodiscard]] std::string coloured(Colour colour, std::string_view text);

/// The curve as `width` characters, each the mean of its share of the values; from '.' at the least to '#' at the
/// largest, so that a serial console shows it too. Pre: values is not empty.
[[nodiscard]] std::string sparkline(const std::vector<double>& values, std::size_t width);

/// Lines of 80 columns at most, what is cut off marked by "..."; coloured() words as the terminal's colours, or plain.
[[nodiscard]] std::string on_screen(std::string_view text, bool in_colour);

/// Whether standard output is a terminal that takes colours: not where NO_COLOR is set (no-color.org).
[[nodiscard]] bool takes_colour();

}  // namespace stillpoint::app
