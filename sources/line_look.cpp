#include "sources/line_look.h"

#include <algorithm>

#include "io/recording_header.h"

namespace stillpoint::sources {
namespace {

bool is_digit(char c) noexcept { return c >= '0' && c <= '9'; }

/// In the pattern 0 stands for any digit.
bool has_pattern(std::string_view line, std::string_view pattern) noexcept {
  const auto fits = [](char c, char p) { return p == '0' ? is_digit(c) : c == p; };
  return std::search(line.begin(), line.end(), pattern.begin(), pattern.end(), fits) != line.end();
}

/// A device's own "[INFO] ready" is none.
bool is_of_json_array(std::string_view line) noexcept {
  if (line.front() == '{') return line.ends_with("},") || line.ends_with("}]");
  if (line == "]") return true;
  if (line.front() != '[') return false;
  const std::string_view rest = io::strip(line.substr(1));
  return rest.empty() || is_digit(rest[0]) || rest[0] == '-' || rest[0] == '[' || rest[0] == '{';
}

/// Other separators show a decimal comma at once. Among commas it shows by fractions such as the 05 of 9,05.
bool has_decimal_commas(std::string_view line) noexcept {
  if (line.find_first_of(";\t") != std::string_view::npos) return has_pattern(line, "0,0");
  if (line.find('.') != std::string_view::npos) return false;
  const auto is_fraction = [&line](std::size_t comma) {
    return comma + 2 < line.size() && line[comma + 1] == '0' && is_digit(line[comma + 2]);
  };
  for (std::size_t comma = line.find(','); comma != std::string_view::npos; comma = line.find(',', comma + 1))
    if (is_fraction(comma)) return true;
  return false;
}

}  // namespace

LineLook look_of(std::string_view line) noexcept {
  line = io::strip(line);
  if (line.empty()) return LineLook::kUnknown;
  if (is_of_json_array(line)) return LineLook::kJsonArray;
  if (has_pattern(line, "0000-00-00") || has_pattern(line, "00:00:00")) return LineLook::kDate;
  if (has_decimal_commas(line)) return LineLook::kDecimalCommas;
  return LineLook::kUnknown;
}

std::string_view advice(LineLook look) noexcept {
  switch (look) {
    case LineLook::kUnknown:
      return {};
    case LineLook::kDecimalCommas:
      return "it looks like decimal commas: write numbers with a point, as 9.81";
    case LineLook::kDate:
      return "it looks like a date or a time of day: send a number under time_s, time_ms, time_us or time_ns, or no "
             "time, and that of arrival serves";
    case LineLook::kJsonArray:
      return "it looks like a JSON array: send one object a line, without brackets around or commas between them";
  }
  return {};
}

}  // namespace stillpoint::sources
