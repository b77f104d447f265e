#include "io/recording.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "io/quote.h"
#include "io/recording_columns.h"

namespace stillpoint::io {

RawSample Recording::sample(std::size_t row) const {
  RawSample s;
  s.t_ns = t_ns[row];
  s.sequence = row;
  const auto take = [row, &s](const std::vector<Vec3>& column, Array3& to, SamplePart part) {
    if (column.empty() || !column[row].allFinite()) return;
    to = array(column[row]);
    s.has = static_cast<std::uint8_t>(s.has | part);
  };
  take(acc_mps2, s.acc_mps2, kAcc);
  take(gyr_radps, s.gyr_radps, kGyr);
  take(mag_uT, s.mag_uT, kMag);
  if (!temp_degC.empty() && std::isfinite(temp_degC[row])) {
    s.temp_degC = temp_degC[row];
    s.has = static_cast<std::uint8_t>(s.has | kTemp);
  }
  return s;
}

namespace {

void format_header(const Recording& r, fmt::memory_buffer& out) {
  const auto to = std::back_inserter(out);
  for (const auto& [key, value] : r.header) fmt::format_to(to, "# {}: {}\n", key, value);
  fmt::format_to(to, "time_ns");
  const auto triad = [&](const char* sensor, const char* unit) {
    for (const char axis : {'x', 'y', 'z'}) fmt::format_to(to, ",{}_{}_{}", sensor, axis, unit);
  };
  if (!r.acc_mps2.empty()) triad("acc", r.acc_in_counts ? "counts" : "mps2");
  if (!r.gyr_radps.empty()) triad("gyr", r.gyr_in_counts ? "counts" : "radps");
  if (!r.mag_uT.empty()) triad("mag", r.mag_in_counts ? "counts" : "uT");
  if (!r.temp_degC.empty()) fmt::format_to(to, ",temp_degC");
  if (!r.current_A.empty()) fmt::format_to(to, ",current_A");
  if (!r.supply_V.empty()) fmt::format_to(to, ",supply_V");
  if (!r.ref_q_world_body.empty()) fmt::format_to(to, ",ref_qw,ref_qx,ref_qy,ref_qz");
  if (!r.ref_position_m.empty()) fmt::format_to(to, ",ref_px_m,ref_py_m,ref_pz_m");
  if (!r.ref_moving.empty()) fmt::format_to(to, ",ref_moving");
  for (const auto& [name, values] : r.user_columns) fmt::format_to(to, ",{}", name);
  fmt::format_to(to, "\n");
}

void format_row(const Recording& r, std::size_t i, fmt::memory_buffer& out) {
  const auto to = std::back_inserter(out);
  const auto number = [&](double x) {
    if (std::isfinite(x))
      fmt::format_to(to, ",{:.10g}", x);
    else
      out.push_back(',');
  };
  const auto numbers = [&](const auto& v) {
    for (Eigen::Index k = 0; k < v.size(); ++k) number(v[k]);
  };
  fmt::format_to(to, "{}", r.t_ns[i]);
  if (!r.acc_mps2.empty()) numbers(r.acc_mps2[i]);
  if (!r.gyr_radps.empty()) numbers(r.gyr_radps[i]);
  if (!r.mag_uT.empty()) numbers(r.mag_uT[i]);
  if (!r.temp_degC.empty()) number(r.temp_degC[i]);
  if (!r.current_A.empty()) number(r.current_A[i]);
  if (!r.supply_V.empty()) number(r.supply_V[i]);
  if (!r.ref_q_world_body.empty()) numbers(r.ref_q_world_body[i]);
  if (!r.ref_position_m.empty()) numbers(r.ref_position_m[i]);
  if (!r.ref_moving.empty()) number(r.ref_moving[i]);
  for (const auto& [name, values] : r.user_columns) number(values[i]);
  out.push_back('\n');
}

std::string_view view(const fmt::memory_buffer& text) { return {text.data(), text.size()}; }

}  // namespace

Result<void> write_header(const Recording& recording, OutputFile& file) {
  fmt::memory_buffer out;
  format_header(recording, out);
  return file.write(view(out));
}

Result<void> write_rows(const Recording& recording, OutputFile& file) {
  fmt::memory_buffer out;
  for (std::size_t i = 0; i < recording.size(); ++i) {
    format_row(recording, i, out);
    if (out.size() <= (1U << 20U)) continue;
    if (auto written = file.write(view(out)); !written) return written;
    out.clear();
  }
  return file.write(view(out));
}

Result<void> write_recording(const Recording& recording, const std::string& path) {
  auto file = OutputFile::create(path);
  if (!file) return tl::unexpected(file.error());
  if (auto written = write_header(recording, *file); !written) return written;
  if (auto written = write_rows(recording, *file); !written) return written;
  return file->flush();
}

std::vector<std::string> describe(const RecordingIssues& i) {
  std::vector<std::string> lines;
  const auto add = [&lines](const Irregularity& what, const char* words) {
    if (what.count > 0) lines.push_back(fmt::format("{} {} (first in line {})", what.count, words, what.first_line));
  };
  add(i.not_finite, "NaN or infinite fields, taken as not measured");
  add(i.repeated_time, "rows with a repeated time, dropped");
  add(i.backward_time, "rows whose time goes back, dropped");
  add(i.malformed, "malformed rows, dropped");
  if (i.gap.count > 0)
    lines.push_back(fmt::format("{} gaps in time, the longest {:.3f} s (first in line {})", i.gap.count,
                                i.longest_gap_s, i.gap.first_line));
  if (i.truncated_last_line) lines.emplace_back("the last line was cut short, dropped");
  for (auto name = i.unknown_columns.begin(); name != i.unknown_columns.end(); ++name) {
    const std::string meant = meant_column(*name);
    const bool no_name = name->empty() || std::find(i.unknown_columns.begin(), name, *name) != name;
    lines.push_back(fmt::format("column {} is not known, {}{}", quote(*name),
                                no_name ? "set aside" : "its numbers are kept under this name",
                                meant.empty() ? "" : fmt::format("; did you mean '{}'?", meant)));
  }
  return lines;
}

}  // namespace stillpoint::io
