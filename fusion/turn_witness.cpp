#include "fusion/turn_witness.h"

#include <algorithm>

namespace stillpoint::fusion {
namespace {

constexpr double kKeep = 0.83;            ///< of the sums, a turn: six turns of 8 degrees
constexpr double kLeastChange_uT2 = 1e2;  ///< noise and an uneven place change a reading by 3 uT
constexpr double kMostLeft = 0.5;

}  // namespace

void TurnWitness::observe(const Vec3& field_world_uT, const Mat3& R_world_body, double time_s) noexcept {
  const auto turn = turns_.observe(field_world_uT, R_world_body, time_s);
  if (!turn) return;
  const double with = turn->change_uT().squaredNorm();
  const double without =
      (turn->R_after.transpose() * turn->after_uT - turn->R_before.transpose() * turn->before_uT).squaredNorm();
  left_uT2_ = kKeep * left_uT2_ + with;
  change_uT2_ = kKeep * change_uT2_ + std::max(with, without);
}

bool TurnWitness::denied() const noexcept {
  return change_uT2_ > kLeastChange_uT2 && left_uT2_ > kMostLeft * change_uT2_;
}

}  // namespace stillpoint::fusion
