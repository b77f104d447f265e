/// The reader of the recording CSV: one pass over the text, every fault with its line and column.
#include "io/recording.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "io/quote.h"
#include "io/recording_columns.h"
#include "io/text_file.h"

namespace stillpoint::io {
namespace {

constexpr std::size_t kMostMessages = 10;
constexpr double kGapOverMedianStep = 2.5;
constexpr double kLatest_ns = 4.6e18;  // 146 years: the difference of any two times still fits

/// Where a column's number goes, and what it is multiplied with on the way.
struct Column {
  std::optional<std::size_t> field;
  double to_si = 1.0;
};

std::string_view strip(std::string_view s) {
  const auto first = s.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return s.substr(first, s.find_last_not_of(" \t\r") - first + 1);
}

/// Takes one line off the text; `ended` is false when the file stops without a newline.
std::string_view take_line(std::string_view& text, bool& ended) {
  const auto end = text.find('\n');
  ended = end != std::string_view::npos;
  const std::string_view line = text.substr(0, end);
  text.remove_prefix(ended ? end + 1 : text.size());
  return line;
}

class Parser {
 public:
  Parser(std::string_view text, const std::string& name, OnMalformedRow policy)
      : text_(text), name_(name), policy_(policy) {}

  Result<Recording> run() {
    if (auto header = read_header(); !header) return tl::unexpected(header.error());
    bool ended = true;
    while (!text_.empty()) {
      ++line_;
      const std::string_view line = take_line(text_, ended);
      read_row(line, ended);
    }
    if (policy_ == OnMalformedRow::kFail && out_.issues.malformed.count > 0) {
      std::string all;
      for (const auto& m : out_.issues.malformed_messages) all += (all.empty() ? "" : "\n") + m;
      if (out_.issues.malformed.count > out_.issues.malformed_messages.size())
        all += fmt::format("\n... and {} more", out_.issues.malformed.count - out_.issues.malformed_messages.size());
      return fail(ErrorKind::kBadData, all);
    }
    if (out_.t_ns.empty())
      return fail(ErrorKind::kBadData, fmt::format("{}:{}: the recording has no rows after its header", name_, line_));
    find_gaps();
    return std::move(out_);
  }

 private:
  Result<void> read_header() {
    bool ended = true;
    std::string_view line;
    do {
      if (text_.empty())
        return fail(ErrorKind::kBadData,
                    fmt::format("{}:{}: no header line; expected column names such as time_s,acc_x_mps2,...", name_,
                                std::max<std::size_t>(line_, 1)));
      ++line_;
      line = strip(take_line(text_, ended));
      if (line_ == 1 && line.substr(0, 3) == "\xEF\xBB\xBF") line = strip(line.substr(3));
      if (!line.empty() && line[0] == '#') {
        const auto colon = line.find(':');
        if (colon != std::string_view::npos)
          out_.header[std::string(strip(line.substr(1, colon - 1)))] = strip(line.substr(colon + 1));
        line = {};
      }
    } while (line.empty());
    return read_columns(line);
  }

  /// What the columns of each group are so far.
  struct Groups {
    std::array<std::size_t, kColumnGroups> seen{};
    std::array<std::string_view, kColumnGroups> unit;
  };

  Result<void> read_columns(std::string_view line) {
    Groups groups;
    for (std::size_t start = 0, end = 0; start <= line.size(); start = end + 1) {
      end = std::min(line.find(',', start), line.size());
      read_column(start + 1, std::string(strip(line.substr(start, end - start))), groups);
    }
    check_groups(line, groups);
    if (!header_faults_.empty()) return fail(ErrorKind::kBadData, header_faults_);
    for (std::size_t g = 0; g < kColumnGroups; ++g) present_[g] = groups.seen[g] > 0;
    out_.acc_in_counts = groups.unit[kAccGroup] == "counts";
    out_.gyr_in_counts = groups.unit[kGyrGroup] == "counts";
    out_.mag_in_counts = groups.unit[kMagGroup] == "counts";
    return {};
  }

  void header_fault(std::size_t column, const std::string& what) {
    header_faults_ += fmt::format("{}{}:{}:{}: {}", header_faults_.empty() ? "" : "\n", name_, line_, column, what);
  }

  void read_column(std::size_t at, const std::string& name, Groups& groups) {
    const auto known = known_column(name);
    if (!known) {
      columns_.push_back({});
      out_.issues.unknown_columns.push_back(name);
      return;
    }
    if (std::find(names_.begin(), names_.end(), name) != names_.end())
      header_fault(at, fmt::format("column '{}' stands twice; remove one", name));
    names_.push_back(name);
    columns_.push_back({known->field, known->to_si});
    std::string_view& unit = groups.unit[known->group];
    if (groups.seen[known->group]++ > 0 && known->group != kTimeGroup && unit != known->unit)
      header_fault(at, fmt::format("column '{}' is in {}, the axis before it in {}; one sensor has one unit", name,
                                   known->unit, unit));
    unit = known->unit;
  }

  void check_groups(std::string_view line, const Groups& groups) {
    const auto& seen = groups.seen;
    if (seen[kTimeGroup] == 0) header_fault(1, "no time column; expected one of time_s, time_ms, time_us, time_ns");
    if (seen[kTimeGroup] > 1) header_fault(1, "more than one time column; keep one");
    for (std::size_t g = kAccGroup; g < kColumnGroups; ++g)
      if (const auto& group = kColumnGroupInfo[g]; seen[g] != 0 && seen[g] != group.size)
        header_fault(1, fmt::format("only {} of the {} columns {}; all or none", seen[g], group.size, group.names));
    const bool no_sensor = seen[kAccGroup] + seen[kGyrGroup] + seen[kMagGroup] == 0;
    if (no_sensor) header_fault(1, "no sensor columns; expected acc_x_mps2, gyr_x_radps or mag_x_uT and their axes");
    if (line.find('\r') == std::string_view::npos && seen[kTimeGroup] > 0 && !no_sensor) return;
    if (const std::string mistake = likely_mistake(line); !mistake.empty()) header_fault(1, mistake);
  }

  void malformed(std::size_t column, const std::string& what) {
    out_.issues.malformed.note(line_);
    if (out_.issues.malformed_messages.size() < kMostMessages)
      out_.issues.malformed_messages.push_back(fmt::format("{}:{}:{}: {}", name_, line_, column, what));
  }

  void read_row(std::string_view line, bool ended) {
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    if (line.empty() || line[0] == '#') return;
    row_.fill(kMissing);
    std::size_t start = 0;
    std::int64_t t_ns = 0;
    bool time_read = false;
    for (std::size_t c = 0; c < columns_.size(); ++c) {
      if (start > line.size()) return cut_or_malformed(ended, c);
      const std::size_t end = std::min(line.find(',', start), line.size());
      const std::string_view text = strip(line.substr(start, end - start));
      if (columns_[c].field && !text.empty()) {
        double value = 0.0;
        const auto [stop, code] = std::from_chars(text.data(), text.data() + text.size(), value);
        if (code == std::errc::invalid_argument || stop != text.data() + text.size()) {
          if (!ended) return cut_or_malformed(ended, c);
          return malformed(start + 1, quote(text) + " is not a number");
        }
        const std::size_t field = *columns_[c].field;
        if (!std::isfinite(value * columns_[c].to_si) || code == std::errc::result_out_of_range) {
          out_.issues.not_finite.note(line_);
        } else if (field == kColumnGroupInfo[kTimeGroup].first) {
          if (!parse_time(text, columns_[c].to_si, value, t_ns))
            return malformed(start + 1,
                             fmt::format("the time {} is out of range; 146 years either way are allowed", quote(text)));
          time_read = true;
        } else {
          row_[field] = value * columns_[c].to_si;
        }
      }
      start = end + 1;
    }
    if (start <= line.size())
      return malformed(start, fmt::format("more than the {} fields of the header", columns_.size()));
    // Without a newline nobody can tell whether the last number was written whole.
    if (!ended) {
      out_.issues.truncated_last_line = true;
      return;
    }
    if (!time_read) return malformed(1, "no time in this row");
    append(t_ns);
  }

  void cut_or_malformed(bool ended, std::size_t fields) {
    if (!ended)
      out_.issues.truncated_last_line = true;
    else
      malformed(1, fmt::format("{} fields, the header has {}", fields, columns_.size()));
  }

  /// Integers in time_ns keep every digit; the others go through a double, rounded to the nanosecond.
  static bool parse_time(std::string_view text, double to_ns, double value, std::int64_t& t_ns) {
    const double ns = value * to_ns;
    if (std::abs(ns) > kLatest_ns) return false;
    if (to_ns == 1.0 && text.find_first_of(".eE") == std::string_view::npos)
      return std::from_chars(text.data(), text.data() + text.size(), t_ns).ec == std::errc{};
    t_ns = std::llround(ns);
    return true;
  }

  void append(std::int64_t t_ns) {
    const bool same_time = !out_.t_ns.empty() && t_ns == out_.t_ns.back();
    if (same_time && !completes_last_row()) return out_.issues.repeated_time.note(line_);
    if (!out_.t_ns.empty() && t_ns < out_.t_ns.back()) return out_.issues.backward_time.note(line_);
    if (same_time) {
      for (std::size_t f = 0; f < row_.size(); ++f)
        if (!std::isfinite(row_[f])) row_[f] = last_row_[f];
    } else {
      out_.t_ns.push_back(t_ns);
      lines_.push_back(line_);
    }
    last_row_ = row_;
    write_last_row();
  }

  /// Loggers that write one sensor a line: the row has something that the one before it lacks, and contradicts nothing.
  [[nodiscard]] bool completes_last_row() const {
    bool any = false;
    for (std::size_t f = 0; f < row_.size(); ++f) {
      if (!std::isfinite(row_[f])) continue;
      if (std::isfinite(last_row_[f]) && row_[f] != last_row_[f]) return false;
      any = any || !std::isfinite(last_row_[f]);
    }
    return any;
  }

  void write_last_row() {
    const auto at = [this](ColumnGroup group, std::size_t k = 0) { return row_[kColumnGroupInfo[group].first + k]; };
    const auto triad = [&](ColumnGroup group) { return Eigen::Vector3d(at(group, 0), at(group, 1), at(group, 2)); };
    const auto put = [this](ColumnGroup group, auto& column, const auto& value) {
      if (!present_[group]) return;
      column.resize(out_.t_ns.size());
      column.back() = value;
    };
    put(kAccGroup, out_.acc_mps2, triad(kAccGroup));
    put(kGyrGroup, out_.gyr_radps, triad(kGyrGroup));
    put(kMagGroup, out_.mag_uT, triad(kMagGroup));
    put(kTempGroup, out_.temp_degC, at(kTempGroup));
    put(kCurrentGroup, out_.current_A, at(kCurrentGroup));
    put(kSupplyGroup, out_.supply_V, at(kSupplyGroup));
    put(kRefAttitudeGroup, out_.ref_q_world_body,
        Eigen::Vector4d(at(kRefAttitudeGroup, 0), at(kRefAttitudeGroup, 1), at(kRefAttitudeGroup, 2),
                        at(kRefAttitudeGroup, 3)));
    put(kRefPositionGroup, out_.ref_position_m, triad(kRefPositionGroup));
    put(kRefMovingGroup, out_.ref_moving, at(kRefMovingGroup));
  }

  void find_gaps() {
    const double step_s = out_.median_step_s();
    for (std::size_t i = 1; i < out_.size(); ++i) {
      const double dt_s = 1e-9 * static_cast<double>(out_.t_ns[i] - out_.t_ns[i - 1]);
      if (dt_s <= kGapOverMedianStep * step_s) continue;
      out_.issues.gap.note(lines_[i]);
      out_.issues.longest_gap_s = std::max(out_.issues.longest_gap_s, dt_s);
    }
  }

  std::string_view text_;
  std::string name_;
  OnMalformedRow policy_;
  std::size_t line_ = 0;
  std::vector<Column> columns_;
  std::vector<std::string> names_;
  std::string header_faults_;
  std::array<bool, kColumnGroups> present_{};
  std::vector<std::size_t> lines_;
  RecordingRow row_{}, last_row_{};
  Recording out_;
};

}  // namespace

Result<Recording> parse_recording(std::string_view text, const std::string& name, OnMalformedRow policy) {
  return Parser(text, name, policy).run();
}

Result<Recording> read_recording(const std::string& path, OnMalformedRow policy) {
  const auto text = read_text_file(path, "a recording (.csv)");
  if (!text) return tl::unexpected(text.error());
  return parse_recording(*text, path, policy);
}

}  // namespace stillpoint::io
