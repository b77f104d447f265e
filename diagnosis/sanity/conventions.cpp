/// Frames, orders and hands that a reference may have been written in.
#include <array>
#include <cmath>

#include "diagnosis/sanity/reference_checks.h"

namespace stillpoint::diag::detail {
namespace {

constexpr double kAnswer_rad = 0.35;  // a convention is named when it brings the angle of the forces below this
constexpr double kLeastRate = 0.3;    // share of the measured rate that it must explain

struct NamedConvention {
  const char* mistake;
  Convention to_enu;
};

const std::array<NamedConvention, 9>& conventions() {
  static const Quat ned(0.0, std::sqrt(0.5), std::sqrt(0.5), 0.0);   // ENU from NED; its own inverse
  static const Quat flip_body(0.0, 1.0, 0.0, 0.0);                   // forward-left-up from forward-right-down
  static const Quat z_up(std::sqrt(0.5), std::sqrt(0.5), 0.0, 0.0);  // z up from y up
  static const std::array<NamedConvention, 9> list{{
      {"conjugated (world to body instead of body to world)", [](const auto& q) { return as_expected(q).conjugate(); }},
      {"in the order x,y,z,w", [](const auto& q) { return Quat(q[3], q[0], q[1], q[2]).normalized(); }},
      {"in a north-east-down world", [](const auto& q) { return ned * as_expected(q); }},
      {"north-east-down to forward-right-down", [](const auto& q) { return ned * as_expected(q) * flip_body; }},
      {"of a body with y right and z down", [](const auto& q) { return as_expected(q) * flip_body; }},
      {"in a world with y up", [](const auto& q) { return z_up * as_expected(q); }},
      {"left-handed (one axis mirrored)", [](const auto& q) { return Quat(q[0], -q[1], q[2], -q[3]).normalized(); }},
      {"left-handed (one axis mirrored)", [](const auto& q) { return Quat(q[0], q[1], -q[2], -q[3]).normalized(); }},
      {"left-handed (one axis mirrored)", [](const auto& q) { return Quat(q[0], -q[1], -q[2], q[3]).normalized(); }},
  }};
  return list;
}

}  // namespace

const char* name_convention(const Comparison& c, const Sanity& known, bool with_position) {
  if (known.unusable[kAcc]) return nullptr;  // without gravity nobody knows which way is up
  for (const auto& [mistake, to_enu] : conventions()) {
    if (!known.unusable[kGyr] && c.rate_agreement(to_enu) < kLeastRate) continue;
    for (const bool position : {false, true}) {
      if (position && !with_position) continue;
      const double force = c.force_angle(to_enu, position);
      if (force >= 0 && force < kAnswer_rad) return mistake;
    }
  }
  return nullptr;
}

}  // namespace stillpoint::diag::detail
