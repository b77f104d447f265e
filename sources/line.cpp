#include "sources/line.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>

#include "io/recording_columns.h"
#include "io/recording_header.h"
#include "sources/json_line.h"

namespace stillpoint::sources {
namespace {

constexpr std::size_t kMostColumns = 64;
constexpr double kNotMeasured = std::numeric_limits<double>::quiet_NaN();
constexpr double kLatest_ns = 4.6e18;  // 146 years: the difference of any two times still fits

bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }

char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

/// Without blanks, and without the mark that some programs set before a text in UTF-8.
std::string_view bare(std::string_view line) noexcept {
  line = io::strip(line);
  if (line.substr(0, 3) == "\xEF\xBB\xBF") line = io::strip(line.substr(3));
  return line;
}

std::string_view unquoted(std::string_view name) noexcept {
  const bool quoted = name.size() > 1 && name.front() == '"' && name.back() == '"';
  return quoted ? name.substr(1, name.size() - 2) : name;
}

/// A name as we write it, whatever letters it was written in. Allocates.
std::string in_our_letters(std::string_view name) {
  std::string out(name);
  std::transform(out.begin(), out.end(), out.begin(), lower);
  for (const std::string_view unit : {"_uT", "_T", "_degC"}) {
    const std::size_t stem = out.size() - std::min(out.size(), unit.size());
    const auto same = [](char a, char b) { return a == lower(b); };
    if (std::equal(out.begin() + static_cast<std::ptrdiff_t>(stem), out.end(), unit.begin(), unit.end(), same))
      out.replace(stem, unit.size(), unit);
  }
  return out;
}

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

/// Commas, semicolons and tabs separate; where there is none, blanks do.
bool separates(char c, bool blanks) noexcept { return c == ',' || c == ';' || c == '\t' || (blanks && c == ' '); }

class Fields {
 public:
  explicit Fields(std::string_view line) noexcept
      : rest_(line), blanks_(line.find_first_of(",;\t") == std::string_view::npos) {}
  bool next(std::string_view& field) noexcept {
    if (done_) return false;
    std::size_t end = 0;
    while (end < rest_.size() && !separates(rest_[end], blanks_)) ++end;
    field = io::strip(rest_.substr(0, end));
    done_ = end == rest_.size();
    if (done_) return true;
    rest_.remove_prefix(end + 1);
    while (blanks_ && !rest_.empty() && rest_[0] == ' ') rest_.remove_prefix(1);
    return true;
  }

 private:
  std::string_view rest_;
  bool blanks_, done_ = false;
};

/// The row's numbers as a reading; false: it holds none.
bool to_reading(const io::RecordingRow& row, std::optional<double> time_unit_ns, Reading& out) noexcept {
  out = {};
  RawSample& s = out.sample;
  const auto take = [&](io::ColumnGroup group, Array3& to, SamplePart part) {
    const std::size_t first = io::kColumnGroupInfo[group].first;
    for (std::size_t k = 0; k < 3; ++k) {
      if (!std::isfinite(row[first + k])) return;
      to[k] = row[first + k];
    }
    s.has = static_cast<std::uint8_t>(s.has | part);
  };
  take(io::kAccGroup, s.acc_mps2, kAcc);
  take(io::kGyrGroup, s.gyr_radps, kGyr);
  take(io::kMagGroup, s.mag_uT, kMag);
  if (const double temp = row[io::kColumnGroupInfo[io::kTempGroup].first]; std::isfinite(temp)) {
    s.temp_degC = temp;
    s.has = static_cast<std::uint8_t>(s.has | kTemp);
  }
  const double t_ns = row[io::kColumnGroupInfo[io::kTimeGroup].first];
  out.has_time = time_unit_ns && std::abs(t_ns) < kLatest_ns;
  if (out.has_time) {
    s.t_ns = std::llround(t_ns);
    out.time_unit_ns = *time_unit_ns;
  }
  return s.has != 0;
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

std::optional<std::size_t> position(const std::string& text) {
  std::size_t value = 0;
  const auto [stop, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (code != std::errc{} || stop != text.data() + text.size() || value == 0 || value > kMostColumns) return {};
  return value - 1;
}

}  // namespace

LineFormat::LineFormat(const io::StreamParams& params)
    : count_to_si_{params.acc_mps2_per_count, params.gyr_radps_per_count, params.mag_uT_per_count} {
  for (const auto& [ours, theirs] : params.columns) {
    const auto field = known_field(ours);
    if (!field) continue;
    if (const auto at = position(theirs)) {
      if (by_position_.size() <= *at) by_position_.resize(*at + 1);
      by_position_[*at] = field;
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

std::optional<Field> LineFormat::field_of_header(std::string_view name) const {
  name = unquoted(name);
  const auto field = field_named(name);
  return field || !by_name_.empty() ? field : known_field(in_our_letters(name));
}

std::optional<Field> LineFormat::field_named(std::string_view name) const noexcept {
  if (by_name_.empty()) return known_field(name);
  const auto found = std::find_if(by_name_.begin(), by_name_.end(), [name](const auto& n) { return n.first == name; });
  return found == by_name_.end() ? std::nullopt : std::optional(found->second);
}

bool LineFormat::use_header(std::string_view line) {
  if (configured_positions_) return false;
  std::vector<std::optional<Field>> fields;
  std::string_view name;
  for (Fields names(bare(line)); names.next(name) && fields.size() < kMostColumns;)
    fields.push_back(field_of_header(name));
  const bool any = std::any_of(fields.begin(), fields.end(), [](const auto& f) {
    return f && f->place != io::kColumnGroupInfo[io::kTimeGroup].first;
  });
  if (any) by_position_ = std::move(fields);
  return any;
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
  return to_reading(row.numbers, row.time_unit_ns, out) ? Piece::kReading : Piece::kIgnored;
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

std::string LineFormat::unknown_names(std::string_view line) const {
  if (!by_name_.empty()) return {};
  std::string names;
  const auto add = [&names](std::string_view name) {
    const std::string meant = io::meant_column(name);
    names += fmt::format("{}{}{}", names.empty() ? "" : ", ", name, meant.empty() ? "" : " (" + meant + "?)");
  };
  line = bare(line);
  if (!line.empty() && line[0] == '{') {
    const bool whole = for_each_number(line, [&](std::string_view name, double) {
      if (!field_of_json(name)) add(name);
    });
    return whole ? names : std::string();
  }
  std::string_view name;
  for (Fields fields(line); fields.next(name);)
    if (!io::known_column(in_our_letters(unquoted(name)))) add(name);
  return names;
}

Piece LineFormat::parse_json(std::string_view line, Reading& out) const noexcept {
  Row row;
  const bool whole = for_each_number(line, [&](std::string_view name, double value) {
    if (const auto field = field_of_json(name)) row.put(*field, value);
  });
  if (!whole) return Piece::kMalformed;
  return to_reading(row.numbers, row.time_unit_ns, out) ? Piece::kReading : Piece::kIgnored;
}

}  // namespace stillpoint::sources
