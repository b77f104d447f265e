/// Is the reference what it claims to be: body to world, ENU, w first, right-handed, and in time with the sensors?
#include <fmt/format.h>

#include <cmath>

#include "core/directions.h"
#include "core/units.h"
#include "diagnosis/sanity/reference_checks.h"
#include "diagnosis/sanity/units.h"

namespace stillpoint::diag::detail {
namespace {

constexpr double kAgree_rad = 0.45;    // median angle between measured and predicted specific force
constexpr double kLeastTurning = 0.3;  // share of the measured rate that the reference explains

void refuse_reference(Sanity& out, std::string why) {
  out.mistake("reference: " + std::move(why));
  out.reference_unusable = true;
}

/// Whether the four columns are unit quaternions in enough rows.
bool holds_quaternions(const io::Recording& r, Sanity& out) {
  std::size_t present = 0, off_norm = 0;
  for (const auto& q : r.ref_q_world_body)
    if (q.allFinite()) ++present, off_norm += std::abs(q.norm() - 1.0) > 0.01;
  if (present < 100)
    refuse_reference(out, "present in fewer than 100 rows; the recording is treated as one without a reference");
  else if (off_norm > present / 20)
    refuse_reference(out, "the quaternions are not of unit length: the four columns are something else (angles?)");
  return !out.reference_unusable;
}

/// The field as the sensors see it in the world of the reference, against the one of the simulation. A motion-capture
/// world has its own heading, and then no calibration of the body's axes can help.
void check_heading(const Comparison& c, const sim::SimulationConfig& config, Sanity& out) {
  if (out.unusable[kMag]) return;
  const auto mean = c.field_in_world();
  const Vec3& field = config.field_world_uT;
  if (!mean || mean->norm() < 0.7 * field.norm() || angle_rad(*mean, field) < 0.5) return;
  out.set_aside(
      kMag, fmt::format(
                "mag: in the world of the reference the field is ({:.1f}, {:.1f}, {:.1f}) uT, {:.0f} degrees from the "
                "simulation's field_world_uT: set that field, or turn the reference to ENU",
                mean->x(), mean->y(), mean->z(), angle_rad(*mean, field) * kDegPerRad));
}

/// A field that does not turn with the body is not measured on it. Offsets, however large, do not matter here.
void check_field_follows(const Comparison& c, Sanity& out) {
  constexpr double kVaried = 0.2, kFollows = 0.15;
  if (out.unusable[kMag]) return;
  const Relation all = c.relation(kMag), r = all.about_means();
  if (r.rows < 100 || r.xx < kVaried * all.xx || r.coherence() > kFollows) return;
  out.set_aside(kMag,
                "mag: its readings do not turn with the body: another sensor's, shuffled rows, or nothing but noise");
}

/// Gyroscope and magnetometer agree with the reference as it is: then the accelerometer is not what it claims to be.
bool only_the_accelerometer_differs(const Comparison& c, Sanity& out) {
  const double field = out.unusable[kMag] ? -1.0 : c.field_angle();
  if (field < 0 || field > kAgree_rad || out.unusable[kGyr] || c.rate_agreement(as_expected) < 0.8) return false;
  const auto before = out.mistakes.size();
  check_axes(c, out);
  return out.mistakes.size() > before;
}

void name_the_mistake(const Comparison& c, const io::Recording& r, Sanity& out) {
  const auto before = out.mistakes.size();
  check_lateness(c, r, out);
  if (out.mistakes.size() > before) return;
  const char* convention = name_convention(c, out, !r.ref_position_m.empty());
  const bool mirrored = convention != nullptr && std::string_view(convention).starts_with("left-handed");
  if ((convention == nullptr || mirrored) && body_is_turned(c, out)) return;
  if (convention == nullptr) check_axes(c, out);
  if (out.mistakes.size() > before) return;
  if (convention == nullptr)
    refuse_reference(out,
                     "it agrees with the sensors in no usual convention (frame, order, handedness, time): it is "
                     "treated as absent");
  else
    refuse_reference(out, fmt::format("the sensors agree with it only if the quaternions are {}; expected are Hamilton "
                                      "quaternions, w first, body to world, in ENU",
                                      convention));
}

}  // namespace

void check_reference(const io::Recording& r, const sim::SimulationConfig& config, Sanity& out) {
  if (!holds_quaternions(r, out)) return;
  const Comparison c(r, config);
  if (!out.unusable[kGyr])
    if (const Relation rates = c.slow_rates(); rates.correlation() > 0.7)
      check_rate_scale(rates.slope(), "the reference", r, config, out);
  if (out.nothing_usable) return;
  const bool with_position = !r.ref_position_m.empty();
  const auto points_up = [&](bool position) {
    const double angle = c.force_angle(as_expected, position);
    return angle >= 0 && angle < kAgree_rad;
  };
  const bool unknown_up =
      out.unusable[kAcc] || (c.force_angle(as_expected, false) < 0 && c.force_angle(as_expected, with_position) < 0);
  const bool turns = out.unusable[kGyr] || c.rate_agreement(as_expected) > kLeastTurning;
  if (turns && (unknown_up || points_up(false) || (with_position && points_up(true)))) {
    if (body_is_turned(c, out)) return;
    check_axes(c, out);
    check_heading(c, config, out);
    check_field_follows(c, out);
    check_position(r, config, out);
  } else if (!only_the_accelerometer_differs(c, out)) {
    name_the_mistake(c, r, out);
  }
}

}  // namespace stillpoint::diag::detail
