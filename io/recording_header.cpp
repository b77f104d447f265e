#include "io/recording_header.h"

#include <fmt/format.h>

#include <algorithm>

#include "io/quote.h"

namespace stillpoint::io {
namespace {

class HeaderReader {
 public:
  explicit HeaderReader(const std::string& file) : file_(file) {}

  Result<RecordingHeader> take(std::string_view& text) {
    bool ended = true;
    std::string_view line;
    do {
      if (text.empty())
        return fail(ErrorKind::kBadData,
                    fmt::format("{}:{}: no header line; expected column names such as time_s,acc_x_mps2,...", file_,
                                std::max<std::size_t>(out_.lines, 1)));
      ++out_.lines;
      line = strip(take_line(text, ended));
      if (out_.lines == 1 && line.substr(0, 3) == "\xEF\xBB\xBF") line = strip(line.substr(3));
      if (!line.empty() && line[0] == '#') {
        const auto colon = line.find(':');
        if (colon != std::string_view::npos)
          out_.keys[std::string(strip(line.substr(1, colon - 1)))] = strip(line.substr(colon + 1));
        line = {};
      }
    } while (line.empty());
    read_columns(line);
    if (!faults_.empty()) return fail(ErrorKind::kBadData, faults_);
    return std::move(out_);
  }

 private:
  void read_columns(std::string_view line) {
    for (std::size_t start = 0, end = 0; start <= line.size(); start = end + 1) {
      end = std::min(line.find(',', start), line.size());
      read_column(start + 1, std::string(strip(line.substr(start, end - start))));
    }
    check_groups(line);
    for (std::size_t g = 0; g < kColumnGroups; ++g) {
      out_.present[g] = seen_[g] > 0;
      out_.in_counts[g] = unit_[g] == "counts";
    }
  }

  void fault(std::size_t column, const std::string& what) {
    faults_ += fmt::format("{}{}:{}:{}: {}", faults_.empty() ? "" : "\n", file_, out_.lines, column, what);
  }

  void read_column(std::size_t at, const std::string& name) {
    const auto known = known_column(name);
    if (!known) return read_user_column(name);
    if (std::find(names_.begin(), names_.end(), name) != names_.end())
      fault(at, fmt::format("column '{}' stands twice; remove one", name));
    names_.push_back(name);
    out_.columns.push_back({known->field, std::nullopt, known->to_si});
    std::string_view& unit = unit_[known->group];
    if (seen_[known->group]++ > 0 && known->group != kTimeGroup && unit != known->unit)
      fault(at, fmt::format("column '{}' is in {}, the axis before it in {}; one sensor has one unit", name,
                            known->unit, unit));
    unit = known->unit;
  }

  void read_user_column(const std::string& name) {
    auto& names = out_.user_columns;
    const bool askable = !name.empty() && std::find(names.begin(), names.end(), name) == names.end();
    out_.columns.push_back({std::nullopt, askable ? std::optional(names.size()) : std::nullopt, 1.0});
    (askable ? names : out_.nameless).push_back(name);
  }

  void check_groups(std::string_view line) {
    if (seen_[kTimeGroup] == 0) fault(1, "no time column; expected one of time_s, time_ms, time_us, time_ns");
    if (seen_[kTimeGroup] > 1) fault(1, "more than one time column; keep one");
    for (std::size_t g = kAccGroup; g < kColumnGroups; ++g)
      if (const auto& group = kColumnGroupInfo[g]; seen_[g] != 0 && seen_[g] != group.size)
        fault(1,
              fmt::format("only {} of the {} columns {}; all or none{}", seen_[g], group.size, group.names, nearly()));
    const bool no_sensor = seen_[kAccGroup] + seen_[kGyrGroup] + seen_[kMagGroup] == 0;
    if (no_sensor)
      fault(1, "no sensor columns; expected acc_x_mps2, gyr_x_radps or mag_x_uT and their axes" + nearly());
    if (line.find('\r') == std::string_view::npos && seen_[kTimeGroup] > 0 && !no_sensor) return;
    if (const std::string mistake = likely_mistake(line); !mistake.empty()) fault(1, mistake);
  }

  /// The first name that is not known and nearly one that is.
  [[nodiscard]] std::string nearly() const {
    for (const auto& name : out_.user_columns)
      if (const std::string meant = meant_column(name); !meant.empty())
        return fmt::format("; {} is not known; did you mean '{}'?", quote(name), meant);
    return {};
  }

  const std::string& file_;
  RecordingHeader out_;
  std::vector<std::string> names_;
  std::string faults_;
  std::array<std::size_t, kColumnGroups> seen_{};
  std::array<std::string_view, kColumnGroups> unit_;
};

}  // namespace

std::string_view strip(std::string_view s) {
  const auto first = s.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return s.substr(first, s.find_last_not_of(" \t\r") - first + 1);
}

std::string_view take_line(std::string_view& text, bool& ended) {
  const auto end = text.find('\n');
  ended = end != std::string_view::npos;
  const std::string_view line = text.substr(0, end);
  text.remove_prefix(ended ? end + 1 : text.size());
  return line;
}

Result<RecordingHeader> take_header(std::string_view& text, const std::string& file) {
  return HeaderReader(file).take(text);
}

}  // namespace stillpoint::io
