#include "sources/line.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>

#include "core/types.h"
#include "io/recording_columns.h"
#include "sources/json_line.h"
#include "sources/line_text.h"

namespace stillpoint::sources {
namespace {

constexpr double kNotMeasured = std::numeric_limits<double>::quiet_NaN();

bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }

/// One number and nothing else; NaN for an empty text. A leading plus sign is taken, as printf("%+f") writes it.
bool parse_number(std::string_view text, double& value) noexcept {
  if (text.empty()) {
    value = kNotMeasured;
    return true;
  }
  if (text[0] == '+' && text.size() > 1 && text[1] != '-') text.remove_prefix(1);
  const auto [stop, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (stop != text.data() + text.size() || code == std::errc::invalid_argument) return false;
  if (code == std::errc::result_out_of_range) value = kNotMeasured;
  return true;
}

/// Collects the numbers of a line.
struct Row {
  io::RecordingRow numbers;
  std::optional<double> time_unit_ns;
  Row() noexcept { numbers.fill(kNotMeasured); }
  void put(const Field& field, double value) noexcept {
    numbers[field.place] = value * field.to_si;
    if (field.place == io::kColumnGroupInfo[io::kTimeGroup].first && std::isfinite(value)) time_unit_ns = field.to_si;
  }
};

Piece to_reading(const Row& row, Reading& out) noexcept {
  out = {};
  RawSample& s = out.sample;
  const auto take = [&](io::ColumnGroup group, Array3& to, SamplePart part) {
    const std::size_t first = io::kColumnGroupInfo[group].first;
    for (std::size_t k = 0; k < 3; ++k) {
      if (!std::isfinite(row.numbers[first + k])) return;
      to[k] = row.numbers[first + k];
    }
    s.has = static_cast<std::uint8_t>(s.has | part);
  };
  take(io::kAccGroup, s.acc_mps2, kAcc);
  take(io::kGyrGroup, s.gyr_radps, kGyr);
  take(io::kMagGroup, s.mag_uT, kMag);
  if (const double temp = row.numbers[io::kColumnGroupInfo[io::kTempGroup].first]; std::isfinite(temp)) {
    s.temp_degC = temp;
    s.has = static_cast<std::uint8_t>(s.has | kTemp);
  }
  if (s.has == 0) return Piece::kIgnored;
  if (!row.time_unit_ns) return Piece::kReading;
  const double t_ns = row.numbers[io::kColumnGroupInfo[io::kTimeGroup].first];
  out.time_unit_ns = *row.time_unit_ns;
  if (!(std::abs(t_ns) < kLatest_ns)) {
    out.refused_time = t_ns / out.time_unit_ns;
    return Piece::kTimeRefused;
  }
  out.has_time = true;
  s.t_ns = std::llround(t_ns);
  return Piece::kReading;
}

}  // namespace

LineFormat::LineFormat(const io::StreamParams& params)
    : count_to_si_{params.acc_mps2_per_count, params.gyr_radps_per_count, params.mag_uT_per_count} {
  for (const auto& [ours, theirs] : params.columns) {
    const auto field = known_field(ours);
    if (!field) continue;
    if (const auto at = io::column_position(theirs)) {
      if (by_position_.size() < *at) by_position_.resize(*at);
      by_position_[*at - 1] = field;
      configured_positions_ = true;
    } else {
      by_name_.emplace_back(theirs, *field);
    }
  }
}

std::optional<Field> LineFormat::known_field(std::string_view name) const noexcept {
  const auto known = io::known_column(name);
  if (!known || known->group > io::kTempGroup) return std::nullopt;
  Field field{known->field, known->to_si};
  if (known->unit == "counts") field.to_si = count_to_si_[known->group - io::kAccGroup];
  return field;
}

std::optional<Field> LineFormat::field_named(std::string_view name) const noexcept {
  if (by_name_.empty()) return known_field(name);
  const auto found = std::find_if(by_name_.begin(), by_name_.end(), [name](const auto& n) { return n.first == name; });
  return found == by_name_.end() ? std::nullopt : std::optional(found->second);
}

Piece LineFormat::parse(std::string_view line, Reading& out) const noexcept {
  line = bare(line);
  if (line.empty() || line[0] == '#') return Piece::kIgnored;
  if (line[0] == '{') return parse_json(line, out);
  const char first = line[0] == '"' && line.size() > 1 ? line[1] : line[0];
  const bool text = is_letter(first) && line.substr(0, 3) != "nan" && line.substr(0, 3) != "inf";
  if (text) return Piece::kHeader;
  return parse_csv(line, out);
}

Piece LineFormat::parse_csv(std::string_view line, Reading& out) const noexcept {
  if (by_position_.empty()) return Piece::kIgnored;  // numbers without names: nobody can say what they are
  Row row;
  std::size_t n = 0;
  std::string_view text;
  for (Fields fields(line); fields.next(text); ++n) {
    if (n >= by_position_.size() && !configured_positions_) return Piece::kMalformed;
    double value = 0.0;
    const bool wanted = n < by_position_.size() && by_position_[n];
    if (!wanted) continue;
    if (!parse_number(unquoted(text), value)) return Piece::kMalformed;
    row.put(*by_position_[n], value);
  }
  if (n < by_position_.size()) return Piece::kMalformed;
  return to_reading(row, out);
}

/// "acc_g": [x, y, z] comes as acc_g.0 and so on, and "acc_g": {"x": ...} as acc_g.x.
std::optional<Field> LineFormat::field_of_json(std::string_view name) const noexcept {
  if (const auto field = field_named(name)) return field;
  std::array<char, 32> axis_name{};
  const std::size_t stem = name.find('_'), dot = name.rfind('.');
  if (stem == std::string_view::npos || dot == std::string_view::npos || dot + 2 != name.size() || dot < stem)
    return {};
  const std::size_t axis = std::string_view("012xyz").find(name[dot + 1]);
  if (axis == std::string_view::npos || dot + 2 > axis_name.size()) return {};
  char* end = std::copy_n(name.data(), stem + 1, axis_name.data());
  *end++ = "xyz"[axis % 3];
  end =
      std::copy(name.begin() + static_cast<std::ptrdiff_t>(stem), name.begin() + static_cast<std::ptrdiff_t>(dot), end);
  return field_named({axis_name.data(), static_cast<std::size_t>(end - axis_name.data())});
}

Piece LineFormat::parse_json(std::string_view line, Reading& out) const noexcept {
  Row row;
  const bool whole = for_each_number(line, [&](std::string_view name, double value) {
    if (const auto field = field_of_json(name)) row.put(*field, value);
  });
  if (!whole) return Piece::kMalformed;
  return to_reading(row, out);
}

}  // namespace stillpoint::sources
