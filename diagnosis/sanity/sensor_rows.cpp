#include "diagnosis/sanity/sensor_rows.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <optional>

#include "diagnosis/sanity/frames.h"
#include "diagnosis/sanity/readings.h"
#include "diagnosis/sanity/rows.h"

namespace stillpoint::diag {
namespace {

constexpr double kApart = 0.02;       // of the inertial rows; fewer are lost readings of those
constexpr double kAsFast = 0.9;       // of their rate
constexpr std::size_t kFewRows = 20;  // no clock can be read from them

using detail::there;

bool inertial(const io::Recording& r, std::size_t row) { return there(r.acc_mps2, row) || there(r.gyr_radps, row); }

/// How often the inertial sensors were read, Hz.
double inertial_rate_hz(const io::Recording& r) {
  io::Recording rows;
  for (std::size_t i = 0; i < r.size(); ++i)
    if (inertial(r, i)) rows.t_ns.push_back(r.t_ns[i]);
  return rows.size() < kFewRows ? 0.0 : 1.0 / rows.median_step_s();
}

/// Of the rows that hold a reading of `one`, how many hold none of `other`.
double share_alone(const io::Recording& r, const std::vector<Vec3>& one, const std::vector<Vec3>& other) {
  double alone = 0.0, all = 0.0;
  for (std::size_t i = 0; i < r.size(); ++i)
    if (there(one, i)) all += 1.0, alone += !there(other, i);
  return all > kFewRows ? alone / all : 0.0;
}

/// What a row that is left out has of temperature, current and supply, kept for the next one.
class Slow {
 public:
  void leave_out(const io::Recording& r, std::size_t row) {
    for (std::size_t k = 0; k < kColumns.size(); ++k)
      if (const auto& column = r.*kColumns[k]; !column.empty() && std::isfinite(column[row])) last_[k] = column[row];
  }
  void give_to_last_row(io::Recording& r) {
    for (std::size_t k = 0; k < kColumns.size(); ++k) {
      auto& column = r.*kColumns[k];
      if (last_[k] && !std::isfinite(column.back())) column.back() = *last_[k];
      last_[k].reset();
    }
  }

 private:
  static constexpr std::array kColumns{&io::Recording::temp_degC, &io::Recording::current_A, &io::Recording::supply_V};
  std::array<std::optional<double>, kColumns.size()> last_;
};

}  // namespace

std::optional<io::Recording> with_inertial_on_rows(const io::Recording& r, std::vector<std::string>& notices) {
  if (share_alone(r, r.acc_mps2, r.gyr_radps) <= kApart || share_alone(r, r.gyr_radps, r.acc_mps2) <= kApart)
    return std::nullopt;
  const detail::Frames<Vec3> acc(r, r.acc_mps2), gyr(r, r.gyr_radps);
  const bool acc_leads = acc.rate_hz() < gyr.rate_hz();
  const auto lead = acc_leads ? &io::Recording::acc_mps2 : &io::Recording::gyr_radps;
  const auto other = acc_leads ? &io::Recording::gyr_radps : &io::Recording::acc_mps2;
  io::Recording out = detail::without_rows(r);
  Slow slow;
  for (std::size_t i = 0; i < r.size(); ++i) {
    const bool other_alone = there(r.*other, i) && !there(r.*lead, i);
    if (other_alone && !there(r.mag_uT, i) && !there(r.ref_q_world_body, i)) {
      slow.leave_out(r, i);
      continue;
    }
    detail::append_row(r, i, out);
    slow.give_to_last_row(out);
    if (other_alone) (out.*other).back().setConstant(io::kMissing);
  }
  // Only where the leader was read: a row of the field or of the reference stays one of its own.
  io::Recording filled = out;
  (acc_leads ? gyr : acc).fill(filled, filled.*other);
  for (std::size_t i = 0; i < out.size(); ++i)
    if (there(out.*lead, i)) (out.*other)[i] = (filled.*other)[i];
  notices.push_back(
      fmt::format("{} and {} were read in rows of their own, {:.4g} and {:.4g} a second; the first is interpolated to "
                  "the rows of the second",
                  acc_leads ? "gyr" : "acc", acc_leads ? "acc" : "gyr", (acc_leads ? gyr : acc).rate_hz(),
                  (acc_leads ? acc : gyr).rate_hz()));
  return out;
}

std::optional<io::Recording> with_field_on_rows(const io::Recording& r, std::vector<std::string>& notices) {
  std::size_t apart = 0, rows = 0;
  for (std::size_t i = 0; i < r.size(); ++i) {
    rows += inertial(r, i);
    apart += there(r.mag_uT, i) && !inertial(r, i);
  }
  if (static_cast<double>(apart) <= kApart * static_cast<double>(rows)) return std::nullopt;
  const double rows_hz = inertial_rate_hz(r);
  if (rows_hz == 0.0) return std::nullopt;
  const detail::Frames<Vec3> field(r, r.mag_uT);
  io::Recording out = detail::without_rows(r);
  for (std::size_t i = 0; i < r.size(); ++i) {
    const bool alone = there(r.mag_uT, i) && !inertial(r, i);
    if (!alone || there(r.ref_q_world_body, i)) detail::append_row(r, i, out);
  }
  const bool fast = field.rate_hz() > kAsFast * rows_hz && field.fill(out, out.mag_uT);
  if (!fast) out.mag_uT.clear();  // what fell on their rows by chance is no sensor that is broken
  notices.push_back(
      fmt::format("mag: {} readings stand in rows of their own between those of the other sensors; {}", apart,
                  fast ? "interpolated to those rows"
                       : fmt::format("{:.4g} a second beside {:.4g}, too few to be interpolated: they are not compared",
                                     field.rate_hz(), rows_hz)));
  return out;
}

std::optional<io::Recording> readings_on_rows(const io::Recording& recording, std::vector<std::string>& notices) {
  std::optional<io::Recording> out;
  for (const auto step : {without_false_values, with_inertial_on_rows, with_field_on_rows})
    if (auto changed = step(out ? *out : recording, notices)) out = std::move(changed);
  return out;
}

}  // namespace stillpoint::diag
