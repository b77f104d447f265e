#include "fusion/two_witnesses.h"

#include <algorithm>
#include <cmath>

namespace stillpoint::fusion {
namespace {

constexpr double kForce_s = 1.0;   ///< within which a hand comes and goes
constexpr double kField_s = 0.2;   ///< the field owes nothing to acceleration
constexpr double kPlace_s = 10.0;  ///< a place is left slowly
constexpr double kUsual_s = 30.0;
/// A fault that lasts becomes usual late, a motion that is only wilder does so at last.
constexpr double kUsualDenied_s = 300.0, kAfterDenial_s = 10.0;
constexpr double kFurther2 = 6.25;      ///< two and a half times the usual
constexpr double kPauseTells_s = 10.0;  ///< until then an attitude that is off is what the start or the pause left
constexpr double kSure_s = 0.1;
/// What a hand's acceleration and an uneven room do without any fault.
constexpr double kLeastLean_rad2 = 0.01, kLeastTurn_rad2 = 0.008;

double angle2(const Vec3& a, const Vec3& b) {
  const double angle = std::atan2(a.cross(b).norm(), a.dot(b));
  return angle * angle;
}

}  // namespace

void TwoWitnesses::Mean::add(const Vec3& x, double time_s, double longest_s) noexcept {
  over_s = std::min(over_s + time_s, longest_s);
  vec(value) += std::min(1.0, time_s / over_s) * (x - Vec3(vec(value)));
}

bool TwoWitnesses::Witness::leaves(double away_now_rad2, double least_rad2, double time_s, double usual_s) noexcept {
  away_rad2 = away_now_rad2;
  const double limit_rad2 = std::max(kFurther2 * usual_rad2, least_rad2);
  usual_rad2 += std::min(1.0, time_s / usual_s) * (std::min(away_rad2, limit_rad2) - usual_rad2);
  return away_rad2 > limit_rad2;
}

void TwoWitnesses::observe(const Vec3& force_mps2, const std::optional<Vec3>& field_uT, double time_s) noexcept {
  if (!(time_s > 0.0) || !force_mps2.allFinite()) return;
  since_pause_s_ += time_s;
  pull_.add(force_mps2, time_s, kForce_s);
  const double usual_s = since_denied_s_ < kAfterDenial_s ? kUsualDenied_s : kUsual_s;
  const bool leans = force_.leaves(angle2(vec(pull_.value), Vec3::UnitZ()), kLeastLean_rad2, time_s, usual_s);
  unheard_s_ = field_uT && field_uT->allFinite() ? 0.0 : unheard_s_ + time_s;
  if (unheard_s_ > kForce_s) denied_s_ = 0.0;
  if (unheard_s_ > 0.0) return;
  now_.add(*field_uT, time_s, kField_s);
  place_.add(*field_uT, time_s, kPlace_s);
  const bool turned = field_.leaves(angle2(vec(now_.value), vec(place_.value)), kLeastTurn_rad2, time_s, usual_s);
  denied_s_ = leans && turned && since_pause_s_ > kPauseTells_s ? denied_s_ + time_s : 0.0;
  since_denied_s_ = denied_s_ > kSure_s ? 0.0 : since_denied_s_ + time_s;
}

double TwoWitnesses::denied_rad2() const noexcept { return denied_s_ > kSure_s ? force_.away_rad2 : 0.0; }

}  // namespace stillpoint::fusion
