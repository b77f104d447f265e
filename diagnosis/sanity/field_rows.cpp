#include "diagnosis/sanity/field_rows.h"

#include <fmt/format.h>

#include "diagnosis/sanity/frames.h"
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

}  // namespace

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
  notices.push_back(
      fmt::format("mag: {} readings stand in rows of their own between those of the other sensors; {}", apart,
                  fast ? "interpolated to those rows"
                       : fmt::format("{:.4g} a second beside {:.4g}, too few to be interpolated: they are not compared",
                                     field.rate_hz(), rows_hz)));
  return out;
}

}  // namespace stillpoint::diag
