#include "diagnosis/sanity/rows_with_reference.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "diagnosis/median.h"
#include "diagnosis/sanity/readings.h"
#include "diagnosis/sanity/rows.h"

namespace stillpoint::diag {
namespace {

constexpr double kHeldShare = 0.1;          // of the turning rows; a lost frame now and then is not a slow camera
constexpr double kTurning_radps = 0.3;      // 30 microradians a row even at 10 kHz: no rounding hides it
constexpr std::size_t kFrozenRows = 3;      // turning ones in a stretch; fewer may be spikes of the gyroscope
constexpr double kLongest = 2.5;            // step between frames that is bridged, over the usual one
constexpr double kSlowestFrames_Hz = 15.0;  // hands move at up to 5 Hz; slower frames do not show how
constexpr double kApart = 0.02;             // of the rows; fewer are lost readings of the others
constexpr std::size_t kReach = 8, kLeastReach = 3;

/// One column of the reference where it was measured.
template <class Value>
class Frames {
 public:
  Frames(const io::Recording& r, const std::vector<Value>& column) {
    for (std::size_t i = 0; i < column.size(); ++i)
      if (column[i].allFinite()) t_s_.push_back(r.t_s(i)), value_.push_back(column[i]);
    for (std::size_t k = 1; Value::SizeAtCompileTime == 4 && k < value_.size(); ++k)
      if (value_[k].dot(value_[k - 1]) < 0) value_[k] *= -1.0;  // q and -q are one rotation
    if (t_s_.size() < 2 * kReach) return;
    std::vector<double> steps;
    for (std::size_t k = 1; k < t_s_.size(); ++k) steps.push_back(t_s_[k] - t_s_[k - 1]);
    usual_s_ = median(std::move(steps));
  }

  [[nodiscard]] double rate_hz() const { return usual_s_ > 0 ? 1.0 / usual_s_ : 0.0; }

  /// Fills what is missing where frames stand on both sides without a break; true when it did somewhere.
  bool fill(const io::Recording& r, std::vector<Value>& column) const {
    bool any = false;
    std::size_t next = 0;  // frame
    for (std::size_t i = 0; i < column.size() && usual_s_ > 0; ++i) {
      while (next < t_s_.size() && t_s_[next] <= r.t_s(i)) ++next;
      if (column[i].allFinite()) continue;
      const std::size_t reach = reach_around(next);
      if (reach < kLeastReach) continue;
      column[i] = between(r.t_s(i), next - reach, next + reach);
      any = true;
    }
    return any;
  }

 private:
  [[nodiscard]] bool joined(std::size_t k) const { return t_s_[k] - t_s_[k - 1] <= kLongest * usual_s_; }
  /// How many frames without a break stand on either side of the step to frame k.
  [[nodiscard]] std::size_t reach_around(std::size_t k) const {
    if (k == 0 || k >= t_s_.size() || !joined(k)) return 0;
    std::size_t reach = 1;
    while (reach < kReach && k > reach && k + reach < t_s_.size() && joined(k - reach) && joined(k + reach)) ++reach;
    return reach;
  }
  [[nodiscard]] Value between(double t_s, std::size_t first, std::size_t last) const {
    Value sum = Value::Zero();
    for (std::size_t j = first; j < last; ++j) {
      double weight = 1.0;
      for (std::size_t m = first; m < last; ++m)
        if (m != j) weight *= (t_s - t_s_[m]) / (t_s_[j] - t_s_[m]);
      sum += weight * value_[j];
    }
    return Value::SizeAtCompileTime == 4 ? Value(sum.normalized()) : sum;
  }

  std::vector<double> t_s_;
  std::vector<Value> value_;
  double usual_s_ = 0.0;
};

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
  const std::vector<bool> repeated = repeats(r);
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

/// The rows of the inertial sensors (of the magnetometer where it is alone), and those in which nothing was measured:
/// lost rows. What comes in rows of its own between them has another clock.
io::Recording rows_of_the_sensors(const io::Recording& r, std::vector<std::string>& notices) {
  io::Recording out = detail::without_rows(r);
  const auto there = [](const auto& column, std::size_t i) { return !column.empty() && column[i].allFinite(); };
  const bool inertial = !r.acc_mps2.empty() || !r.gyr_radps.empty();
  std::size_t apart = 0;
  for (std::size_t i = 0; i < r.size(); ++i) {
    const bool field = there(r.mag_uT, i), reference = there(r.ref_q_world_body, i);
    const bool ours = there(r.acc_mps2, i) || there(r.gyr_radps, i) || (field && !inertial);
    if (ours || !(field || reference)) detail::append_row(r, i, out);
    apart += field && !ours;
  }
  if (static_cast<double>(apart) > kApart * static_cast<double>(out.size()))
    notices.push_back(
        fmt::format("mag: {} readings stand in rows of their own between those of the other sensors and "
                    "are not compared; interpolate them to those rows",
                    apart));
  return out;
}

}  // namespace

std::optional<io::Recording> rows_with_reference(const io::Recording& given, std::vector<std::string>& notices) {
  io::Recording r = given;
  const std::vector<bool> filled = filled_in(r);
  const auto held = std::count(filled.begin(), filled.end(), true);
  for (std::size_t i = 0; i < r.size(); ++i) {
    if (!filled[i]) continue;
    r.ref_q_world_body[i].setConstant(io::kMissing);
    if (!r.ref_position_m.empty()) r.ref_position_m[i].setConstant(io::kMissing);
  }
  const Frames<Eigen::Vector4d> turns(r, r.ref_q_world_body);
  const Frames<Vec3> places(r, r.ref_position_m);
  r = rows_of_the_sensors(r, notices);
  bool changed = held > 0 || r.size() < given.size();
  if (auto even = with_lost_rows(r)) r = std::move(*even), changed = true;
  if (turns.rate_hz() >= kSlowestFrames_Hz) {
    changed = turns.fill(r, r.ref_q_world_body) || changed;
    changed = places.fill(r, r.ref_position_m) || changed;
  }
  if (!changed) return std::nullopt;
  if (held > 0)
    notices.push_back(
        fmt::format("reference: in {} rows it repeats itself while the body turns; those values are taken out", held));
  const double rows_hz = 1.0 / std::max(r.median_step_s(), 1e-9);
  if (turns.rate_hz() < 0.9 * rows_hz)
    notices.push_back(fmt::format("reference: {:.4g} frames a second beside {:.4g} rows of the sensors; {}",
                                  turns.rate_hz(), rows_hz,
                                  turns.rate_hz() < kSlowestFrames_Hz ? "too few to know the motion between them"
                                                                      : "interpolated between its frames"));
  return r;
}

}  // namespace stillpoint::diag
