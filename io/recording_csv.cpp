/// The reader of the recording CSV: one pass over the text, every fault with its line and column.
#include "io/recording.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>

namespace stillpoint::io {
namespace {

constexpr std::size_t kMostMessages = 10;
constexpr double kGapOverMedianStep = 2.5;

struct Row {
  double time = kMissing;  // in the unit of the time column; kept apart, an int64 of ns is made of it
  double acc[3], gyr[3], mag[3], q[4], p[3];
  double temp, current, supply, moving;
  void clear() {
    auto* first = &acc[0];
    std::fill(first, &moving + 1, kMissing);
    time = kMissing;
  }
};
static_assert(sizeof(Row) == 21 * sizeof(double), "clear() fills the row as one run of doubles");

/// Where a column's number goes, and what it is multiplied with on the way.
struct Column {
  double* (*slot)(Row&) = nullptr;
  double to_si = 1.0;
};

struct Known {
  const char* name;
  double to_si;
  double* (*slot)(Row&);
  int group;  // which triad or single column, for the completeness check
};

enum Group { kTime, kAccG, kGyrG, kMagG, kTempG, kCurrentG, kSupplyG, kRefQ, kRefP, kMoving, kGroups };
constexpr std::array<int, kGroups> kGroupSize{1, 3, 3, 3, 1, 1, 1, 4, 3, 1};
constexpr std::array<const char*, kGroups> kGroupName{
    "time_s",    "acc_x/y/z_mps2", "gyr_x/y/z_radps", "mag_x/y/z_uT",   "temp_degC",
    "current_A", "supply_V",       "ref_qw/qx/qy/qz", "ref_px/py/pz_m", "ref_moving"};

#define SP_TRIAD(sensor, member, suffix, factor, group)                                       \
  {sensor "_x_" suffix, factor, [](Row& r) -> double* { return &r.member[0]; }, group},       \
      {sensor "_y_" suffix, factor, [](Row& r) -> double* { return &r.member[1]; }, group}, { \
    sensor "_z_" suffix, factor, [](Row& r) -> double* { return &r.member[2]; }, group        \
  }

constexpr double kG = 9.80665;
constexpr double kDeg = 0.017453292519943295;
const std::vector<Known>& known_columns() {
  static const std::vector<Known> columns{
      {"time_s", 1e9, [](Row& r) { return &r.time; }, kTime},
      {"time_ms", 1e6, [](Row& r) { return &r.time; }, kTime},
      {"time_us", 1e3, [](Row& r) { return &r.time; }, kTime},
      {"time_ns", 1.0, [](Row& r) { return &r.time; }, kTime},
      SP_TRIAD("acc", acc, "mps2", 1.0, kAccG),
      SP_TRIAD("acc", acc, "g", kG, kAccG),
      SP_TRIAD("acc", acc, "counts", 1.0, kAccG),
      SP_TRIAD("gyr", gyr, "radps", 1.0, kGyrG),
      SP_TRIAD("gyr", gyr, "dps", kDeg, kGyrG),
      SP_TRIAD("gyr", gyr, "counts", 1.0, kGyrG),
      SP_TRIAD("mag", mag, "uT", 1.0, kMagG),
      SP_TRIAD("mag", mag, "gauss", 100.0, kMagG),
      SP_TRIAD("mag", mag, "T", 1e6, kMagG),
      SP_TRIAD("mag", mag, "counts", 1.0, kMagG),
      {"temp_degC", 1.0, [](Row& r) { return &r.temp; }, kTempG},
      {"current_A", 1.0, [](Row& r) { return &r.current; }, kCurrentG},
      {"supply_V", 1.0, [](Row& r) { return &r.supply; }, kSupplyG},
      {"ref_qw", 1.0, [](Row& r) { return &r.q[0]; }, kRefQ},
      {"ref_qx", 1.0, [](Row& r) { return &r.q[1]; }, kRefQ},
      {"ref_qy", 1.0, [](Row& r) { return &r.q[2]; }, kRefQ},
      {"ref_qz", 1.0, [](Row& r) { return &r.q[3]; }, kRefQ},
      {"ref_px_m", 1.0, [](Row& r) { return &r.p[0]; }, kRefP},
      {"ref_py_m", 1.0, [](Row& r) { return &r.p[1]; }, kRefP},
      {"ref_pz_m", 1.0, [](Row& r) { return &r.p[2]; }, kRefP},
      {"ref_moving", 1.0, [](Row& r) { return &r.moving; }, kMoving},
  };
  return columns;
}

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

  Result<void> read_columns(std::string_view line) {
    std::array<int, kGroups> seen{};
    std::array<std::string, kGroups> suffix;
    std::string faults;
    const auto add_fault = [&](std::size_t column, const std::string& what) {
      faults += fmt::format("{}{}:{}:{}: {}", faults.empty() ? "" : "\n", name_, line_, column, what);
    };
    std::size_t start = 0;
    while (start <= line.size()) {
      const std::size_t end = std::min(line.find(',', start), line.size());
      const std::string name(strip(line.substr(start, end - start)));
      const auto& known = known_columns();
      const auto it = std::find_if(known.begin(), known.end(), [&](const Known& k) { return name == k.name; });
      if (it == known.end()) {
        columns_.push_back({});
        out_.issues.unknown_columns.push_back(name);
      } else {
        const auto group = static_cast<std::size_t>(it->group);
        if (std::find(names_.begin(), names_.end(), name) != names_.end())
          add_fault(start + 1, fmt::format("column '{}' stands twice; remove one", name));
        names_.push_back(name);
        columns_.push_back({it->slot, it->to_si});
        ++seen[group];
        if (group >= kAccG && group <= kMagG) {
          const std::string unit = name.substr(name.rfind('_') + 1);
          if (!suffix[group].empty() && suffix[group] != unit)
            add_fault(start + 1, fmt::format("column '{}' is in {}, the axis before it in {}; one sensor has one unit",
                                             name, unit, suffix[group]));
          suffix[group] = unit;
        }
      }
      start = end + 1;
    }
    if (seen[kTime] == 0) add_fault(1, "no time column; expected one of time_s, time_ms, time_us, time_ns");
    if (seen[kTime] > 1) add_fault(1, "more than one time column; keep one");
    for (std::size_t g = kAccG; g < kGroups; ++g)
      if (seen[g] != 0 && seen[g] != kGroupSize[g])
        add_fault(1, fmt::format("only {} of the {} columns {}; all or none", seen[g], kGroupSize[g], kGroupName[g]));
    if (seen[kAccG] + seen[kGyrG] + seen[kMagG] == 0)
      add_fault(1, "no sensor columns; expected acc_x_mps2, gyr_x_radps or mag_x_uT and their axes");
    if (!faults.empty()) return fail(ErrorKind::kBadData, faults);
    for (std::size_t g = 0; g < kGroups; ++g) present_[g] = seen[g] > 0;
    out_.acc_in_counts = suffix[kAccG] == "counts";
    out_.gyr_in_counts = suffix[kGyrG] == "counts";
    out_.mag_in_counts = suffix[kMagG] == "counts";
    return {};
  }

  void malformed(std::size_t column, const std::string& what) {
    out_.issues.malformed.note(line_);
    if (out_.issues.malformed_messages.size() < kMostMessages)
      out_.issues.malformed_messages.push_back(fmt::format("{}:{}:{}: {}", name_, line_, column, what));
  }

  void read_row(std::string_view line, bool ended) {
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    if (line.empty() || line[0] == '#') return;
    row_.clear();
    std::size_t start = 0;
    std::int64_t t_ns = 0;
    bool time_read = false;
    for (std::size_t c = 0; c < columns_.size(); ++c) {
      if (start > line.size()) return cut_or_malformed(ended, c);
      const std::size_t end = std::min(line.find(',', start), line.size());
      const std::string_view text = strip(line.substr(start, end - start));
      if (columns_[c].slot != nullptr && !text.empty()) {
        double value = 0.0;
        const auto [stop, code] = std::from_chars(text.data(), text.data() + text.size(), value);
        if (code == std::errc::invalid_argument || stop != text.data() + text.size()) {
          if (!ended) return cut_or_malformed(ended, c);
          return malformed(start + 1, fmt::format("'{}' is not a number", text.substr(0, 40)));
        }
        double* slot = columns_[c].slot(row_);
        if (!std::isfinite(value) || code == std::errc::result_out_of_range) {
          out_.issues.not_finite.note(line_);
        } else if (slot == &row_.time) {
          if (!parse_time(text, columns_[c].to_si, value, t_ns)) return malformed(start + 1, "time out of range");
          time_read = true;
        } else {
          *slot = value * columns_[c].to_si;
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
    if (to_ns == 1.0 && text.find_first_of(".eE") == std::string_view::npos)
      return std::from_chars(text.data(), text.data() + text.size(), t_ns).ec == std::errc{};
    const double ns = value * to_ns;
    if (std::abs(ns) > 9.2e18) return false;
    t_ns = std::llround(ns);
    return true;
  }

  void append(std::int64_t t_ns) {
    if (!out_.t_ns.empty() && t_ns == out_.t_ns.back()) return out_.issues.repeated_time.note(line_);
    if (!out_.t_ns.empty() && t_ns < out_.t_ns.back()) return out_.issues.backward_time.note(line_);
    out_.t_ns.push_back(t_ns);
    lines_.push_back(line_);
    if (present_[kAccG]) out_.acc_mps2.emplace_back(row_.acc[0], row_.acc[1], row_.acc[2]);
    if (present_[kGyrG]) out_.gyr_radps.emplace_back(row_.gyr[0], row_.gyr[1], row_.gyr[2]);
    if (present_[kMagG]) out_.mag_uT.emplace_back(row_.mag[0], row_.mag[1], row_.mag[2]);
    if (present_[kTempG]) out_.temp_degC.push_back(row_.temp);
    if (present_[kCurrentG]) out_.current_A.push_back(row_.current);
    if (present_[kSupplyG]) out_.supply_V.push_back(row_.supply);
    if (present_[kRefQ]) out_.ref_q_world_body.emplace_back(row_.q[0], row_.q[1], row_.q[2], row_.q[3]);
    if (present_[kRefP]) out_.ref_position_m.emplace_back(row_.p[0], row_.p[1], row_.p[2]);
    if (present_[kMoving]) out_.ref_moving.push_back(row_.moving);
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
  std::array<bool, kGroups> present_{};
  std::vector<std::size_t> lines_;
  Row row_{};
  Recording out_;
};

}  // namespace

Result<Recording> parse_recording(std::string_view text, const std::string& name, OnMalformedRow policy) {
  return Parser(text, name, policy).run();
}

Result<Recording> read_recording(const std::string& path, OnMalformedRow policy) {
  namespace fs = std::filesystem;
  std::error_code unknown;
  const fs::file_type kind = fs::status(path, unknown).type();
  std::ifstream file(path, std::ios::binary);
  if (!file)
    return fail(ErrorKind::kNoInput, fmt::format("{}: cannot be opened; check the path and its permissions", path));
  if (kind != fs::file_type::regular && kind != fs::file_type::fifo)
    return fail(ErrorKind::kNoInput, fmt::format("{}: neither a file nor a pipe; name a recording (.csv)", path));
  std::string text;
  if (kind == fs::file_type::regular) text.reserve(static_cast<std::size_t>(fs::file_size(path, unknown)) + 1);
  std::array<char, 1 << 16> part{};
  while (file.read(part.data(), part.size()) || file.gcount() > 0)
    text.append(part.data(), static_cast<std::size_t>(file.gcount()));
  if (file.bad()) return fail(ErrorKind::kNoInput, fmt::format("{}: cannot be read to its end", path));
  return parse_recording(text, path, policy);
}

}  // namespace stillpoint::io
