#include "fusion/field_reference.h"

#include <algorithm>
#include <cmath>

namespace stillpoint::fusion {

double FieldReference::Field::squared_distance(double horizontal, double vertical) const noexcept {
  const double dh = horizontal - horizontal_uT;
  const double dv = vertical - vertical_uT;
  return dh * dh + dv * dv;
}

void FieldReference::Field::follow(double horizontal, double vertical, double weight) noexcept {
  horizontal_uT += weight * (horizontal - horizontal_uT);
  vertical_uT += weight * (vertical - vertical_uT);
}

void FieldReference::rescale(double factor) noexcept {
  for (double* part :
       {&reference_.horizontal_uT, &reference_.vertical_uT, &candidate_.horizontal_uT, &candidate_.vertical_uT})
    *part *= factor;
}

bool FieldReference::follow_candidate(const FieldReferenceParams& params, const Field& now, double limit, double time_s,
                                      bool moving) noexcept {
  if (candidate_.squared_distance(now.horizontal_uT, now.vertical_uT) > limit * limit) {
    candidate_ = now;
    candidate_s_ = 0.0;
    return false;
  }
  candidate_.follow(now.horizontal_uT, now.vertical_uT, std::min(1.0, time_s / (candidate_s_ + time_s)));
  if (moving) candidate_s_ += time_s;  // lying beside a magnet the field is steady too
  return candidate_s_ >= params.accept_time_s;
}

FieldVerdict FieldReference::observe(const FieldReferenceParams& params, double horizontal_uT, double vertical_uT,
                                     double time_s, bool moving) noexcept {
  FieldVerdict verdict;
  if (!std::isfinite(horizontal_uT) || !std::isfinite(vertical_uT) || horizontal_uT < params.smallest_horizontal_uT ||
      std::hypot(horizontal_uT, vertical_uT) > params.largest_uT) {
    candidate_s_ = 0.0;
    return verdict;
  }
  const Field now{horizontal_uT, vertical_uT};
  if (!known()) reference_ = now;
  const double limit = params.tolerance * std::hypot(reference_.horizontal_uT, reference_.vertical_uT);
  const double distance2 = reference_.squared_distance(horizontal_uT, vertical_uT);
  verdict.heading_variance_rad2 = 0.5 * distance2 / (horizontal_uT * horizontal_uT);
  verdict.trusted = distance2 <= limit * limit;
  if (verdict.trusted) {
    candidate_s_ = 0.0;
    learnt_s_ = std::min(learnt_s_ + time_s, params.learn_time_s);
    reference_.follow(horizontal_uT, vertical_uT, std::min(1.0, time_s / learnt_s_));
  } else if (follow_candidate(params, now, limit, time_s, moving)) {
    reference_ = candidate_;
    learnt_s_ = candidate_s_;
    candidate_s_ = 0.0;
    verdict.accepted = true;
  }
  return verdict;
}

}  // namespace stillpoint::fusion
