#include "fusion/offset_jumps.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace stillpoint::fusion {
namespace {

constexpr double kWindow_s = 8.0;         ///< 8 to 16 s do alike
constexpr double kFirst_s = 0.5;          ///< of a window: too little to say anything
constexpr double kJump_radps = 0.05;      ///< deviation of what a jump may be: 3 deg/s
constexpr double kJump_mps2 = 1.0;        ///< a tenth of gravity
constexpr double kLeast_radps = 0.005;    ///< below them it is a drift, which the random walk follows: 0.3 deg/s
constexpr double kLeast_mps2 = 0.5;       ///< and three degrees of tilt
constexpr double kLeastUsual = 0.8;       ///< a motion that the parameters call too lively by far
constexpr double kRemembered = 30.0;      ///< windows
constexpr double kForceIsNoOffset = 8.0;  ///< accelerations last, and a wrong scale leans with the attitude
constexpr double kSpread = 0.02;          ///< of the vertical in the body: eight degrees
constexpr double kUnlikelyAlike = 20.0;   ///< of a body that does not turn an acceleration says the same
constexpr double kPriorSurprise = 7.0;    ///< twice the log odds against a jump in a window: one in thirty-three

constexpr bool of_gyroscope(int jump) { return jump % 2 == 0; }

}  // namespace

OffsetJumps::Candidate OffsetJumps::judge(const ErrorState& error, int jump, double colour) noexcept {
  const JumpEvidence& e = error.jump_evidence(jump);
  const double sd = of_gyroscope(jump) ? kJump_radps : kJump_mps2;
  const Mat3 information = mat(e.information) / colour + Mat3::Identity() / (sd * sd);
  Candidate c;
  c.jump = jump;
  c.covariance = information.inverse();
  c.size = c.covariance * vec(e.score) / colour;
  c.surprise = vec(e.score).dot(c.size) / colour;
  return c;
}

void OffsetJumps::begin(ErrorState& error, int window) noexcept {
  error.begin_jump(2 * window, kGyrBias);
  error.begin_jump(2 * window + 1, kAccBias);
  age_s_[static_cast<std::size_t>(window)] = 0.0;
}

void OffsetJumps::restart(ErrorState& error) noexcept {
  for (int w = 0; w < kJumpWindows; ++w) begin(error, w);
  age_s_[1] = 0.5 * kWindow_s;
  doubt_rad2_ = {};
}

void OffsetJumps::end_windows(ErrorState& error, double period_s) noexcept {
  for (int w = 0; w < kJumpWindows; ++w) {
    double& age_s = age_s_[static_cast<std::size_t>(w)];
    age_s += period_s;
    if (age_s < kWindow_s) continue;
    windows_ = std::min(windows_ + 1.0, kRemembered);
    usual_ += (judge(error, 2 * w, 1.0).surprise - usual_) / windows_;
    begin(error, w);
  }
}

double OffsetJumps::still() const noexcept {
  return std::max(0.0, 1.0 - (1.0 - vec(mean_up_).squaredNorm()) / kSpread);
}

OffsetJumps::Verdict OffsetJumps::observe(ErrorState& error, const Vec3& up_body, bool carried,
                                          double period_s) noexcept {
  end_windows(error, period_s);
  const bool first = mean_up_ == Array3{};
  vec(mean_up_) += (first ? 1.0 : std::min(1.0, period_s / kWindow_s)) * (up_body - vec(mean_up_));
  doubt_rad2_ = {};
  // Innovations are no white noise: a hand's next swing follows from its last. What they usually make of it counts.
  const double usual = std::max(kLeastUsual, usual_);
  const double unlikely_alike = kUnlikelyAlike * still();
  const auto believable = [&](const Candidate& c) {
    return c.surprise > kPriorSurprise + (of_gyroscope(c.jump) && carried ? kUnlikelyAlike : unlikely_alike);
  };
  Candidate likeliest;
  for (int jump = 0; jump < kJumps; ++jump) {
    if (age_s_[static_cast<std::size_t>(jump / 2)] < kFirst_s) continue;
    const Candidate c = judge(error, jump, of_gyroscope(jump) ? usual : kForceIsNoOffset * usual);
    if (std::pair(believable(c), c.surprise) > std::pair(believable(likeliest), likeliest.surprise)) likeliest = c;
  }
  if (!(likeliest.surprise > 0.0) || !likeliest.size.allFinite() || !likeliest.covariance.allFinite())
    return Verdict::kNone;
  const bool gyroscope = of_gyroscope(likeliest.jump);
  const bool likely = believable(likeliest);
  double probability = 1.0 / (1.0 + std::exp(0.5 * (kPriorSurprise - likeliest.surprise)));
  if (!likely) probability = std::min(0.5, probability);
  if (likely && likeliest.size.norm() > (gyroscope ? kLeast_radps : kLeast_mps2)) {
    error.believe_jump(likeliest.jump, likeliest.size, likeliest.covariance);
    restart(error);
    return gyroscope ? Verdict::kGyroscope : Verdict::kAccelerometer;
  }
  // Stated is the variance of both: the estimate without a jump, and the one with it beside it.
  const Mat3 turned = error.turned_by_jump(likeliest.jump);
  const Mat3 of_jump = likeliest.covariance + (1.0 - probability) * likeliest.size * likeliest.size.transpose();
  mat(doubt_rad2_) = probability * turned * of_jump * turned.transpose();
  return Verdict::kNone;
}

}  // namespace stillpoint::fusion
