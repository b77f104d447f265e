#include "exchange/table.h"
#include "io/recording_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>

namespace stillpoint::exchange {
namespace {

std::string_view take_line(std::string_view& text) {
  const auto end = text.find('\n');
  const std::string_view line = text.substr(0, end);
  text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  const auto first = line.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return line.substr(first, line.find_last_not_of(" \r") - first + 1);  // tabs at the end stand for empty fields
}

/// Fields between separators that stand outside quotes; a run of spaces is one separator. Empty ones at the end are
/// left out, for programs that end rows with a separator; gives how many fields there are with them.
std::size_t split(std::string_view line, char separator, std::vector<std::string_view>& out) {
  out.clear();
  bool quoted = false;
  std::size_t start = 0;
  for (std::size_t i = 0; i <= line.size(); ++i) {
    if (i < line.size() && line[i] == '"') quoted = !quoted;
    if (i < line.size() && (quoted || line[i] != separator)) continue;
    std::string_view field = io::strip(line.substr(start, i - start));
    if (field.size() >= 2 && field.front() == '"' && field.back() == '"') field = field.substr(1, field.size() - 2);
    if (separator != ' ' || !field.empty()) out.push_back(io::strip(field));
    start = i + 1;
  }
  const std::size_t all = out.size();
  while (!out.empty() && out.back().empty()) out.pop_back();
  return all;
}

/// A decimal comma counts where the comma does not separate.
std::optional<double> number(std::string_view field, bool decimal_comma) {
  if (field.empty()) return std::nullopt;
  std::string with_point;
  if (decimal_comma && field.find(',') != std::string_view::npos) {
    with_point = field;
    std::replace(with_point.begin(), with_point.end(), ',', '.');
    field = with_point;
  }
  if (field.front() == '+') field.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
  if (error != std::errc() || end != field.data() + field.size()) return std::nullopt;
  return value;
}

std::optional<std::int64_t> whole_number(std::string_view field) {
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
  if (error != std::errc() || end != field.data() + field.size()) return std::nullopt;
  return value;
}

constexpr std::int64_t kExact = std::int64_t{1} << 50;  ///< beyond it a double no longer tells ns apart

class TableReader {
 public:
  TableReader(std::string_view text, const std::string& name) : text_(text) { table_.name = name; }

  Result<Table> run() {
    if (text_.substr(0, 3) == "\xEF\xBB\xBF") text_.remove_prefix(3);
    if (text_.substr(0, 4096).find('\0') != std::string_view::npos)
      return fail(ErrorKind::kBadData, table_.name + ":1:1: no text; a table of numbers or a known log is wanted");
    while (!text_.empty()) {
      const std::string_view line = take_line(text_);
      ++line_;
      if (line.empty()) continue;
      if (auto done = table_.columns.empty() ? start(line) : row(line); !done) return tl::unexpected(done.error());
    }
    if (table_.rows() == 0)
      return fail(ErrorKind::kBadData,
                  fmt::format("{}:{}: no rows of numbers", table_.name, std::max<std::size_t>(line_, 1)));
    return std::move(table_);
  }

 private:
  /// A line before the first row of numbers: kept as what may be the header.
  Result<void> start(std::string_view line) {
    if (!choose_separator(line)) {
      // A comment such as "# rate: 100" is no header, a commented header is one.
      candidate_ = std::string(line);
      return {};
    }
    std::vector<std::string_view> names;
    std::string_view header = candidate_;
    while (!header.empty() && (header.front() == '#' || header.front() == '%')) header = io::strip(header.substr(1));
    split(header, separator_, names);
    // A table with one sensor a row leaves the columns of the others empty.
    if (names.size() < fields_.size() || names.size() > all_fields_) {
      if (!candidate_.empty() && candidate_.front() != '#' && candidate_.front() != '%' && names.size() > 1)
        return fail(ErrorKind::kBadData, fmt::format("{}:{}: {} fields under {} column names; is a name missing?",
                                                     table_.name, line_, fields_.size(), names.size()));
      names.clear();
    }
    for (std::size_t i = 0; i < (names.empty() ? all_fields_ : names.size()); ++i)
      table_.columns.push_back({names.empty() ? std::to_string(i + 1) : std::string(names[i]), 0, {}, 0});
    return row(line);
  }

  /// The separator with which more than half of the line's fields that are not empty are numbers, two at least.
  bool choose_separator(std::string_view line) {
    for (const char separator : {'\t', ';', ',', ' '}) {
      all_fields_ = split(line, separator, fields_);
      const bool comma = separator == '\t' || separator == ';';
      const auto numbers = std::count_if(fields_.begin(), fields_.end(),
                                         [&](std::string_view f) { return number(f, comma).has_value(); });
      const auto filled = std::count_if(fields_.begin(), fields_.end(), [](std::string_view f) { return !f.empty(); });
      if (numbers < 2 || 2 * numbers <= filled) continue;
      separator_ = separator;
      decimal_comma_ = comma;
      return true;
    }
    return false;
  }

  Result<void> row(std::string_view line) {
    if (line.front() == '#' || line.front() == '%') return {};
    all_fields_ = split(line, separator_, fields_);
    if (fields_.size() > table_.columns.size())
      return fail(ErrorKind::kBadData, fmt::format("{}:{}: {} fields, the header has {}", table_.name, line_,
                                                   fields_.size(), table_.columns.size()));
    const bool cut = text_.empty() && all_fields_ < table_.columns.size();
    if (cut && table_.rows() > 0) return {};  // the last row, cut short by a power loss
    for (std::size_t i = 0; i < table_.columns.size(); ++i)
      add(table_.columns[i], i < fields_.size() ? fields_[i] : std::string_view());
    table_.lines.push_back(line_);
    return {};
  }

  void add(Column& column, std::string_view field) {
    double value = std::numeric_limits<double>::quiet_NaN();
    if (const auto whole = whole_number(field)) {
      if (column.values.empty() && (*whole > kExact || *whole < -kExact)) column.origin = *whole;
      std::int64_t beyond = 0;
      value = __builtin_sub_overflow(*whole, column.origin, &beyond)
                  ? static_cast<double>(*whole) - static_cast<double>(column.origin)
                  : static_cast<double>(beyond);
    } else if (const auto x = number(field, decimal_comma_)) {
      value = *x - static_cast<double>(column.origin);
    }
    column.numbers += std::isfinite(value) ? 1 : 0;
    column.values.push_back(value);
  }

  std::string_view text_;
  Table table_;
  std::string candidate_;
  std::vector<std::string_view> fields_;
  std::size_t all_fields_ = 0;  ///< with the empty ones at the end
  std::size_t line_ = 0;
  char separator_ = ',';
  bool decimal_comma_ = false;
};

}  // namespace

const Column* Table::find(std::string_view column) const {
  for (const Column& c : columns)
    if (c.name == column) return &c;
  return nullptr;
}

Result<Table> parse_table(std::string_view text, const std::string& name) { return TableReader(text, name).run(); }

}  // namespace stillpoint::exchange
