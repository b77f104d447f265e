#include "apps/stillpoint/screen.h"

#include <unistd.h>

#include <algorithm>
#include <cstdlib>

namespace stillpoint::app {
namespace {

constexpr std::size_t kColumns = 80;
constexpr char kPlain = '\4';

bool is_mark(char c) { return c >= static_cast<char>(Colour::kGood) && c <= kPlain; }

std::string_view escape_of(char mark) {
  switch (mark) {
    case static_cast<char>(Colour::kGood):
      return "\033[32m";
    case static_cast<char>(Colour::kWarn):
      return "\033[33m";
    case static_cast<char>(Colour::kBad):
      return "\033[1;31m";
    default:
      return "\033[0m";
  }
}

}  // namespace

std::string coloured(Colour colour, std::string_view text) {
  return static_cast<char>(colour) + std::string(text) + kPlain;
}

std::string sparkline(const std::vector<double>& values, std::size_t width) {
  constexpr std::string_view kRamp = ".:-=+*#";
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  const double step = std::max(*most - *least, 1e-12) / static_cast<double>(kRamp.size());
  std::string out;
  for (std::size_t i = 0; i < width; ++i) {
    const std::size_t first = i * values.size() / width, end = std::max(first + 1, (i + 1) * values.size() / width);
    double sum = 0.0;
    for (std::size_t k = first; k < end; ++k) sum += values[k];
    const auto level = static_cast<std::size_t>((sum / static_cast<double>(end - first) - *least) / step);
    out += kRamp[std::min(level, kRamp.size() - 1)];
  }
  return out;
}

std::string on_screen(std::string_view text, bool in_colour) {
  constexpr std::string_view kMore = "...";
  std::string out;
  for (std::size_t start = 0, end = 0; start < text.size(); start = end + 1) {
    end = std::min(text.find('\n', start), text.size());
    const std::string_view line = text.substr(start, end - start);
    const auto width = line.size() - static_cast<std::size_t>(std::count_if(line.begin(), line.end(), is_mark));
    const std::size_t shown = width > kColumns ? kColumns - kMore.size() : width;
    std::size_t column = 0;
    for (const char c : line) {
      if (is_mark(c) && in_colour) out += escape_of(c);
      if (!is_mark(c) && column++ < shown) out += c;
    }
    if (shown < width) out += kMore;
    out += '\n';
  }
  return out;
}

bool takes_colour() { return isatty(STDOUT_FILENO) != 0 && std::getenv("NO_COLOR") == nullptr; }

}  // namespace stillpoint::app
