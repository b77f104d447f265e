#include "fusion/iron_finder.h"

#include <algorithm>
#include <cmath>

namespace stillpoint::fusion {
namespace {

constexpr double kMemory = 400.0;  ///< turns
constexpr double kLargestIron_uT = 1000.0;
constexpr double kSmallestNoise_uT = 0.5;  ///< of the change between two readings
/// Places are uneven in step with the motion of a hand or a leg: the residual alone would promise too much.
constexpr double kUneven_uT = 1.5;
constexpr double kCorrelated = 4.0;
constexpr double kOutlier = 3.0;
/// The last ten turns deny the iron by three deviations on average: another magnet is there, or it is gone.
constexpr double kDenied = 9.0, kDeniedOver = 10.0;

}  // namespace

void IronFinder::observe(const Vec3& seen_world_uT, const Mat3& R_world_body, double time_s) noexcept {
  if (!seen_world_uT.allFinite()) return;
  if (const auto turn = short_turns_.observe(seen_world_uT, R_world_body, time_s))
    add_turn(turn->turn(), turn->change_uT());
}

/// Turns of two irons make one that never was. What comes after is taken alone, and has to last: beside a magnet of the
/// room a dozen turns would do.
void IronFinder::forget() noexcept {
  information_ = {};
  weighted_ = body_ = {};
  changes2_ = turns_ = 0.0;
  denied_ = 1.0;
  fewest_ = 0.5 * kMemory;
}

double IronFinder::degrees_of_freedom() const noexcept { return std::max(1.0, 3.0 * turns_ - 3.0); }

double IronFinder::residual_uT2() const noexcept {
  const double left = (changes2_ - vec(weighted_).dot(vec(body_))) / degrees_of_freedom();
  return std::max(left, kSmallestNoise_uT * kSmallestNoise_uT);
}

void IronFinder::add_turn(const Mat3& turn, const Vec3& change_uT) noexcept {
  double weight = 1.0;
  if (known()) {  // after Cauchy: a magnet that passes counts little
    const double r2 = (change_uT - turn * vec(body_)).squaredNorm() / 3.0 / residual_uT2();
    weight = 1.0 / (1.0 + r2 / (kOutlier * kOutlier));
    denied_ += (r2 - denied_) / kDeniedOver;
    if (denied_ > kDenied) {
      forget();
      return;
    }
  }
  const double keep = 1.0 - 1.0 / kMemory;
  mat(information_) = Mat3(keep * mat(information_) + weight * turn.transpose() * turn);
  vec(weighted_) = Vec3(keep * vec(weighted_) + weight * turn.transpose() * change_uT);
  changes2_ = keep * changes2_ + weight * change_uT.squaredNorm();
  turns_ = keep * turns_ + weight;
  Mat3 information = mat(information_);
  information.diagonal().array() += 1.0 / (kLargestIron_uT * kLargestIron_uT);
  vec(body_) = information.ldlt().solve(vec(weighted_));
  if (!vec(body_).allFinite()) *this = {};
}

Mat3 IronFinder::covariance_uT2() const noexcept {
  Mat3 information = mat(information_) / (kCorrelated * residual_uT2());
  information.diagonal().array() += 1.0 / (kLargestIron_uT * kLargestIron_uT);
  return information.inverse() + kUneven_uT * kUneven_uT * Mat3::Identity();
}

void IronFinder::rebase(const Mat3& K, const Vec3& c) noexcept {
  if (K.isIdentity(1e-12) && c.isZero(1e-9)) return;  // another version of the calibration, of the same numbers
  const Vec3 body = K * Vec3(vec(body_)) + c;
  const double scale = std::cbrt(std::abs(K.determinant())), left_uT2 = residual_uT2();
  // The sums are of the former readings: their information stays, turned to the new unit, about the new value, and so
  // does the misfit that they were weighed by.
  mat(information_) /= scale * scale;
  vec(body_) = body;
  vec(weighted_) = mat(information_) * body;
  changes2_ = body.dot(vec(weighted_)) + left_uT2 * degrees_of_freedom();
  short_turns_.interrupt();
}

}  // namespace stillpoint::fusion
