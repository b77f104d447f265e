/// The reader of the recording CSV: one pass over the text, every fault with its line and column.
#include "io/recording.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "core/types.h"
#include "io/quote.h"
#include "io/recording_header.h"
#include "io/text_file.h"

namespace stillpoint::io {
namespace {

constexpr std::size_t kMostMessages = 10;

class Parser {
 public:
  Parser(std::string_view text, const std::string& name, OnMalformedRow policy)
      : text_(text), name_(name), policy_(policy) {}

  Result<Recording> run() {
    auto header = take_header(text_, name_);
    if (!header) return tl::unexpected(header.error());
    begin(std::move(*header));
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
    if (out_.issues.backward_time.count > out_.size())
      return fail(ErrorKind::kBadData,
                  fmt::format("{}:{}: the time goes back, in {} of {} rows; a recording's rows stand in the order of "
                              "their time: sort them, or name the column that is the time",
                              name_, out_.issues.backward_time.first_line, out_.issues.backward_time.count,
                              out_.issues.backward_time.count + out_.size()));
    find_gaps(out_, lines_);
    return std::move(out_);
  }

 private:
  void begin(RecordingHeader header) {
    header_ = std::move(header);
    line_ = header_.lines;
    out_.header = header_.keys;
    out_.acc_in_counts = header_.in_counts[kAccGroup];
    out_.gyr_in_counts = header_.in_counts[kGyrGroup];
    out_.mag_in_counts = header_.in_counts[kMagGroup];
    out_.issues.unknown_columns = header_.user_columns;
    out_.issues.unknown_columns.insert(out_.issues.unknown_columns.end(), header_.nameless.begin(),
                                       header_.nameless.end());
    user_.resize(header_.user_columns.size());
    last_user_ = user_;
    for (const auto& name : header_.user_columns) user_to_.push_back(&out_.user_columns[name]);
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
    std::fill(user_.begin(), user_.end(), kMissing);
    std::size_t start = 0;
    t_ns_.reset();
    for (std::size_t c = 0; c < header_.columns.size(); ++c) {
      if (start > line.size()) return cut_or_malformed(ended, c);
      const std::size_t end = std::min(line.find(',', start), line.size());
      const std::string_view text = strip(line.substr(start, end - start));
      if (!text.empty())
        if (const std::string fault = read_field(header_.columns[c], text); !fault.empty())
          return ended ? malformed(start + 1, fault) : cut_or_malformed(ended, c);
      start = end + 1;
    }
    if (start <= line.size())
      return malformed(start, fmt::format("more than the {} fields of the header", header_.columns.size()));
    // Without a newline nobody can tell whether the last number was written whole.
    if (!ended) {
      out_.issues.truncated_last_line = true;
      return;
    }
    if (!t_ns_) return malformed(1, "no time in this row");
    append(*t_ns_);
  }

  /// What is wrong with it; empty: nothing. A text in a user column is no number of it, and no fault.
  std::string read_field(const RecordingColumn& column, std::string_view text) {
    double value = 0.0;
    const auto [stop, code] = std::from_chars(text.data(), text.data() + text.size(), value);
    const bool number = code != std::errc::invalid_argument && stop == text.data() + text.size();
    if (!column.field) {
      if (column.user && number && std::isfinite(value)) user_[*column.user] = value;
      return {};
    }
    if (!number) return quote(text) + " is not a number";
    if (!std::isfinite(value * column.to_si) || code == std::errc::result_out_of_range) {
      out_.issues.not_finite.note(line_);
    } else if (*column.field == kColumnGroupInfo[kTimeGroup].first) {
      std::int64_t t_ns = 0;
      if (!parse_time(text, column.to_si, value, t_ns))
        return fmt::format("the time {} is out of range; 146 years either way are allowed", quote(text));
      t_ns_ = t_ns;
    } else {
      row_[*column.field] = value * column.to_si;
    }
    return {};
  }

  void cut_or_malformed(bool ended, std::size_t fields) {
    if (!ended)
      out_.issues.truncated_last_line = true;
    else
      malformed(1, fmt::format("{} fields, the header has {}", fields, header_.columns.size()));
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
      keep_known(last_row_, row_);
      keep_known(last_user_, user_);
    } else {
      out_.t_ns.push_back(t_ns);
      lines_.push_back(line_);
    }
    last_row_ = row_;
    last_user_ = user_;
    write_last_row();
  }

  template <class Numbers>
  static void keep_known(const Numbers& before, Numbers& now) {
    for (std::size_t f = 0; f < now.size(); ++f)
      if (!std::isfinite(now[f])) now[f] = before[f];
  }

  /// Loggers that write one sensor a line: the row has something that the one before it lacks, and contradicts nothing.
  [[nodiscard]] bool completes_last_row() const {
    bool any = false;
    const auto compatible = [&any](const auto& before, const auto& now) {
      for (std::size_t f = 0; f < now.size(); ++f) {
        if (!std::isfinite(now[f])) continue;
        if (std::isfinite(before[f]) && now[f] != before[f]) return false;
        any = any || !std::isfinite(before[f]);
      }
      return true;
    };
    return compatible(last_row_, row_) && compatible(last_user_, user_) && any;
  }

  void write_last_row() {
    const auto at = [this](ColumnGroup group, std::size_t k = 0) { return row_[kColumnGroupInfo[group].first + k]; };
    const auto triad = [&](ColumnGroup group) { return Eigen::Vector3d(at(group, 0), at(group, 1), at(group, 2)); };
    const auto put = [this](ColumnGroup group, auto& column, const auto& value) {
      if (!header_.present[group]) return;
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
    for (std::size_t c = 0; c < user_.size(); ++c) {
      user_to_[c]->resize(out_.t_ns.size());
      user_to_[c]->back() = user_[c];
    }
  }

  std::string_view text_;
  std::string name_;
  OnMalformedRow policy_;
  std::size_t line_ = 0;
  RecordingHeader header_;
  std::vector<std::size_t> lines_;
  std::optional<std::int64_t> t_ns_;  ///< of the row that is being read
  RecordingRow row_{}, last_row_{};
  std::vector<double> user_, last_user_;
  std::vector<std::vector<double>*> user_to_;
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
