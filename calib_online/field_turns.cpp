#include "calib_online/field_turns.h"

#include <Eigen/LU>
#include <cmath>

#include "core/so3.h"
#include "core/units.h"

namespace stillpoint::calib {
namespace {

constexpr double kLongestStep_s = 0.25;  // longer, and the rotation is not known
constexpr std::int64_t kBlock_ns = 100'000'000;
constexpr std::int64_t kApart_ns = 500'000'000;     // closer, and both means see the same unevenness of the place
constexpr std::int64_t kTooOld_ns = 2'000'000'000;  // longer, and the body has moved to another field
constexpr double kLeastTurn_rad = 0.35;             // of the result; less says nothing against the noise
constexpr double kLongestPath_rad = 6.0;            // longer, and the gyro's scale error outweighs the field's

}  // namespace

void FieldTurnFinder::restart() noexcept {
  block_ = Block{};
  anchor_.set = false;
  started_ = false;
}

std::optional<FieldTurn> FieldTurnFinder::push(const RawSample& s, std::uint8_t clipped,
                                               const CalibrationSnapshot& calibration,
                                               const Array3& mag_turn_rad) noexcept {
  const double step_s = in_seconds(s.t_ns - last_t_ns_);
  if (!s.holds(kGyr) || !vec(s.gyr_radps).allFinite() || (clipped & (kGyr | kMag)) != 0 ||
      (started_ && !(step_s > 0.0 && step_s < kLongestStep_s))) {
    restart();
  }
  if (!s.holds(kGyr) || !vec(s.gyr_radps).allFinite() || (clipped & kGyr) != 0) return std::nullopt;
  turn(s, calibration);
  if (s.holds(kMag) && (clipped & kMag) == 0 && vec(s.mag_uT).allFinite() && s.mag_uT != last_field_uT_) {
    // A reading that is held until the next one is a reading once, at the time when it was new.
    last_field_uT_ = s.mag_uT;
    if (block_.count == 0) {
      block_.turned = Quat::Identity();
      block_.t_start_ns = s.t_ns;
    }
    const Quat at_reading = block_.turned * exp_quat(Vec3(-vec(mag_turn_rad)));
    const Vec3 u = at_reading * calibration.mag.apply(s.mag_uT, s.temp_degC);
    if (block_.count > 0) block_.step_sq += (u - block_.last).squaredNorm();
    block_.last = u;
    block_.sum += u;
    block_.turned_sum += log_quat(at_reading);
    ++block_.count;
  }
  if (block_.count == 0 || s.t_ns - block_.t_start_ns < kBlock_ns) return std::nullopt;
  return close_block(s, calibration);
}

/// Trapezoid over the step.
void FieldTurnFinder::turn(const RawSample& s, const CalibrationSnapshot& calibration) noexcept {
  const Vec3 rate = calibration.gyr.apply(s.gyr_radps, s.temp_degC);
  if (started_) {
    const Vec3 phi = 0.5 * (rate + last_rate_) * in_seconds(s.t_ns - last_t_ns_);
    const Quat step = exp_quat(phi);
    block_.turned = renormalized(block_.turned * step);
    anchor_.turned = renormalized(anchor_.turned * step);
    anchor_.path_rad += phi.norm();
  }
  last_rate_ = rate;
  last_t_ns_ = s.t_ns;
  started_ = true;
}

std::optional<FieldTurn> FieldTurnFinder::close_block(const RawSample& s,
                                                      const CalibrationSnapshot& calibration) noexcept {
  const Quat first_middle = exp_quat(Vec3(block_.turned_sum / block_.count));  // v_first = R v_middle
  const Quat middle_now = first_middle.conjugate() * block_.turned;
  const Vec3 now = first_middle.conjugate() * block_.sum / block_.count;
  const Array3 mean_uT =
      array(Vec3(mat(calibration.mag.matrix).inverse() * now + calibration.mag.bias_at(s.temp_degC)));
  // Half the mean square step over three axes is the variance of a reading.
  const double noise_uT2 = block_.count > 1 ? block_.step_sq / (6.0 * (block_.count - 1) * block_.count) : 0.0;
  block_ = Block{};
  std::optional<FieldTurn> out;
  if (anchor_.set && s.t_ns - anchor_.t_ns < kApart_ns) return out;
  const Quat q = anchor_.turned * middle_now.conjugate();
  const bool turned = anchor_.set && 2.0 * std::atan2(q.vec().norm(), std::abs(q.w())) > kLeastTurn_rad;
  const bool lost = s.t_ns - anchor_.t_ns > kTooOld_ns || anchor_.path_rad > kLongestPath_rad;
  if (anchor_.set && !turned && !lost) return out;
  if (turned && !lost)
    out = FieldTurn{.t_end_ns = s.t_ns,
                    .temp_degC = s.temp_degC,
                    .before_uT = anchor_.mean_uT,
                    .after_uT = mean_uT,
                    .q_before_after = {q.w(), q.x(), q.y(), q.z()},
                    .noise_uT2 = anchor_.noise_uT2 + noise_uT2,
                    .path_rad = anchor_.path_rad,
                    .time_s = in_seconds(s.t_ns - anchor_.t_ns)};
  anchor_ = Anchor{
      .set = true, .mean_uT = mean_uT, .noise_uT2 = noise_uT2, .t_ns = s.t_ns, .turned = middle_now, .path_rad = 0.0};
  return out;
}

}  // namespace stillpoint::calib
