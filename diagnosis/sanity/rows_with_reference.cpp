#include "diagnosis/sanity/rows_with_reference.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "diagnosis/sanity/frames.h"
#include "diagnosis/sanity/frames_between.h"
#include "diagnosis/sanity/frames_off_rows.h"
#include "diagnosis/sanity/readings.h"
#include "diagnosis/sanity/rows.h"

namespace stillpoint::diag {
namespace {

constexpr double kHeldShare = 0.1;          // of the turning rows; a lost frame now and then is not a slow camera
constexpr double kTurning_radps = 0.3;      // 30 microradians a row even at 10 kHz: no rounding hides it
constexpr std::size_t kFrozenRows = 3;      // turning ones in a stretch; fewer may be spikes of the gyroscope
constexpr double kSlowestFrames_Hz = 15.0;  // hands move at up to 5 Hz; slower frames do not show how

/// Rows in which the reference is, to the last decimal, that of the row before.
std::vector<bool> repeats(const io::Recording& r) {
  const auto& q = r.ref_q_world_body;
  const auto& p = r.ref_position_m;
  std::vector<bool> out(r.size(), false);
  for (std::size_t i = 1; i < r.size(); ++i) out[i] = q[i] == q[i - 1] && (p.empty() || p[i] == p[i - 1]);
  return out;
}

/// Those of them that were filled in: all where it often repeats itself while the body turns, else the stretches over
/// which it did.
std::vector<bool> filled_in(const io::Recording& r) {
  std::vector<bool> repeated = repeats(r);
  const auto turns = [&r](std::size_t i) { return !r.gyr_radps.empty() && r.gyr_radps[i].norm() > kTurning_radps; };
  double turning = 0.0, held = 0.0;
  for (std::size_t i = 0; i < r.size(); ++i)
    if (r.ref_q_world_body[i].allFinite() && turns(i)) turning += 1, held += repeated[i];
  if (turning > 100 && held > kHeldShare * turning) return repeated;
  std::vector<bool> out(r.size(), false);
  for (std::size_t begin = 0, end = 0; begin < r.size(); begin = end + 1) {
    std::size_t moved = 0;
    for (end = begin; end < r.size() && repeated[end]; ++end) moved += turns(end);
    if (moved >= kFrozenRows)
      std::fill(out.begin() + static_cast<std::ptrdiff_t>(begin), out.begin() + static_cast<std::ptrdiff_t>(end), true);
  }
  return out;
}

template <class Value>
void forget(std::vector<Value>& column) {
  for (Value& v : column) v.setConstant(io::kMissing);
}

/// The rows of the inertial sensors (of the magnetometer where it is alone), and those in which nothing was measured:
/// lost rows. What comes in rows of its own between them has another clock.
io::Recording rows_of_the_sensors(const io::Recording& r) {
  io::Recording out = detail::without_rows(r);
  using detail::there;
  const bool inertial = !r.acc_mps2.empty() || !r.gyr_radps.empty();
  for (std::size_t i = 0; i < r.size(); ++i) {
    const bool field = there(r.mag_uT, i), reference = there(r.ref_q_world_body, i);
    const bool ours = there(r.acc_mps2, i) || there(r.gyr_radps, i) || (field && !inertial);
    if (ours || !(field || reference)) detail::append_row(r, i, out);
  }
  return out;
}

}  // namespace

RowsWithReference rows_with_reference(const io::Recording& given, std::vector<std::string>& notices) {
  io::Recording r = given;
  const DrawnRows lines = rows_drawn_between_frames(r);
  std::vector<bool> filled = filled_in(r);
  const auto held = std::count(filled.begin(), filled.end(), true);
  for (std::size_t i = 0; i < lines.drawn.size(); ++i) filled[i] = filled[i] || lines.drawn[i];
  for (std::size_t i = 0; i < r.size(); ++i) {
    if (!filled[i]) continue;
    r.ref_q_world_body[i].setConstant(io::kMissing);
    if (!r.ref_position_m.empty()) r.ref_position_m[i].setConstant(io::kMissing);
  }
  detail::Frames<Eigen::Vector4d> turns(r, r.ref_q_world_body);
  detail::Frames<Vec3> places(r, r.ref_position_m);
  std::optional<FramesOffRows> off_rows;
  if (lines.rows_a_frame == 1 && held == 0) off_rows = frames_off_rows(r);
  if (off_rows) {
    turns = {off_rows->turns_t_s, off_rows->turns_world_body};
    forget(r.ref_q_world_body);
  }
  if (off_rows && !off_rows->places_t_s.empty()) {
    places = {off_rows->places_t_s, off_rows->places_m};
    forget(r.ref_position_m);
  }
  r = rows_of_the_sensors(r);
  bool changed = held > 0 || lines.lost_rows > 0 || lines.rows_a_frame > 1 || off_rows || r.size() < given.size();
  if (auto even = with_lost_rows(r)) r = std::move(*even), changed = true;
  if (turns.rate_hz() >= kSlowestFrames_Hz) {
    changed = turns.fill(r, r.ref_q_world_body) || changed;
    changed = places.fill(r, r.ref_position_m) || changed;
  }
  if (!changed) return {};
  if (held > 0)
    notices.push_back(
        fmt::format("reference: in {} rows it repeats itself while the body turns; those values are taken out", held));
  if (lines.lost_rows > 0)
    notices.push_back(
        fmt::format("reference: over lost frames a line was drawn while the body moves; {} more rows are taken out",
                    lines.lost_rows));
  const double rows_hz = 1.0 / std::max(r.median_step_s(), 1e-9);
  if (turns.rate_hz() < 0.9 * rows_hz)
    notices.push_back(
        fmt::format("reference: {:.4g} frames a second beside {:.4g} rows of the sensors; {}", turns.rate_hz(), rows_hz,
                    turns.rate_hz() < kSlowestFrames_Hz  ? "too few to know the motion between them"
                    : lines.rows_a_frame > 1 || off_rows ? "drawn as lines between its frames, which count alone"
                                                         : "interpolated between its frames"));
  const double rows_a_frame = turns.rate_hz() > 0 ? std::round(rows_hz / turns.rate_hz()) : 1.0;
  return {std::move(r), static_cast<std::size_t>(std::max(rows_a_frame, 1.0))};
}

}  // namespace stillpoint::diag
