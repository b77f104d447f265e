#include "core/gravity_turns.h"

#include <algorithm>
#include <cmath>

#include "core/units.h"

namespace stillpoint {
namespace {

constexpr std::int64_t kBlock_ns = 200'000'000;
constexpr std::int64_t kHole_ns = 1'000'000'000;
constexpr std::size_t kFreshBlocks = 8;
constexpr double kLikeGravity = 0.3;
constexpr double kNormError = 1.15;  // of an accelerometer that nobody calibrated

}  // namespace

void GravityTurns::Noise::push(const Array3& reading) noexcept {
  if (!differences.push(reading)) return;
  const Array3 noise2 = differences.noise2(kOrder);
  sum2 += (noise2[0] + noise2[1] + noise2[2]) / 3.0;
  ++n;
}

double GravityTurns::Noise::take() noexcept {
  const double mean = n > 0 ? sum2 / n : 0.0;
  sum2 = 0.0;
  n = 0;
  return mean;
}

void GravityTurns::push_acc(const Array3& reading) noexcept {
  for (std::size_t k = 0; k < 3; ++k) force_sum_[k] += reading[k];
  ++forces_;
  acc_noise_.push(reading);
}

void GravityTurns::push_gyr(const Array3& reading, std::int64_t t_ns) noexcept {
  const std::int64_t step_ns = t_ns - last_gyr_ns_;
  if (!started_ || step_ns <= 0 || step_ns > kHole_ns) {
    clear();
    started_ = true;
    block_start_ns_ = t_ns;
  } else {
    const double half_s = 0.5e-9 * static_cast<double>(step_ns);
    for (std::size_t k = 0; k < 3; ++k) turn_[k] += half_s * (reading[k] + last_rate_[k]);
    ++rates_;
  }
  last_rate_ = reading;
  last_gyr_ns_ = t_ns;
  gyr_noise_.push(reading);
  if (t_ns - block_start_ns_ >= kBlock_ns) close_block(t_ns);
}

void GravityTurns::close_block(std::int64_t t_ns) noexcept {
  if (forces_ == 0 || rates_ == 0) return clear();
  newest_ = (newest_ + 1) % kBlocks;
  Block& block = blocks_[newest_];
  for (std::size_t k = 0; k < 3; ++k) block.force[k] = force_sum_[k] / forces_;
  block.turn_rad = turn_;
  block.seconds = in_seconds(t_ns - block_start_ns_);
  block.acc_noise2 = acc_noise_.take();
  block.gyr_noise2 = gyr_noise_.take();
  filled_ = std::min(filled_ + 1, kBlocks);
  ++fresh_;
  force_sum_ = turn_ = {};
  forces_ = rates_ = 0;
  block_start_ns_ = t_ns;
}

bool GravityTurns::ready() noexcept {
  if (filled_ < kBlocks || fresh_ < kFreshBlocks) return false;
  fresh_ = 0;
  return true;
}

double GravityTurns::gravity_turn_rad() const noexcept {
  Vec3 first = Vec3::Zero(), last = Vec3::Zero();
  for (std::size_t i = 0; i < kBlocks / 4; ++i) {
    first += vec(block(i).force) / (kBlocks / 4);
    last += vec(block(kBlocks - 1 - i).force) / (kBlocks / 4);
  }
  const auto like_gravity = [](const Vec3& f) {
    return std::abs(f.norm() - kStandardGravity_mps2) < kLikeGravity * kStandardGravity_mps2;
  };
  if (!like_gravity(first) || !like_gravity(last)) return 0.0;
  return std::acos(std::clamp(first.normalized().dot(last.normalized()), -1.0, 1.0));
}

double GravityTurns::usual_gyr_noise2() const noexcept {
  std::array<double, kBlocks> each{};
  std::transform(blocks_.begin(), blocks_.end(), each.begin(), [](const Block& b) { return b.gyr_noise2; });
  std::nth_element(each.begin(), each.begin() + kBlocks / 2, each.end());
  return each[kBlocks / 2];
}

TurnsFit GravityTurns::fit() const noexcept {
  Vec3 mean_turn = Vec3::Zero(), mean_force = Vec3::Zero();
  double seconds = 0.0, acc_noise2 = 0.0;
  for (const Block& b : blocks_) {
    acc_noise2 += b.acc_noise2 / kBlocks;
    mean_turn += vec(b.turn_rad) / kBlocks;
    mean_force += vec(b.force) / kBlocks;
    seconds += b.seconds;
  }
  TurnsFit out;
  double xx = 0.0, xy = 0.0;
  for (std::size_t i = 1; i < kBlocks; ++i) {
    const Vec3 before = vec(block(i - 1).force), now = vec(block(i).force);
    const double norm = 0.5 * (before.norm() + now.norm());
    if (!(norm > 0.0)) return {};
    const Vec3 turn = 0.5 * (vec(block(i - 1).turn_rad) + vec(block(i).turn_rad)) - mean_turn;
    const Vec3 told = -turn.cross(Vec3(0.5 * (before + now))) / norm, seen = (now - before) / norm;
    xx += told.squaredNorm();
    xy += told.dot(seen);
    out.turned_rad2 += seen.squaredNorm();
  }
  if (xx > 0.0 && out.turned_rad2 > 0.0) {
    out.scale = xy / xx;
    out.explained = xy * xy / (xx * out.turned_rad2);
  }
  Vec3 mean_direction = Vec3::Zero();
  for (const Block& b : blocks_) mean_direction += vec(b.force).normalized() / kBlocks;
  out.held = mean_direction.norm();
  const Vec3 up = mean_direction.normalized();
  const Vec3 rate = mean_turn * static_cast<double>(kBlocks) / seconds;
  // Circling about the vertical tilts the mean force, and the more so the stronger it is.
  const double g = kStandardGravity_mps2 / (kNormError * mean_force.norm());
  const double tilt = std::sqrt(std::max(0.0, 1.0 - g * g));
  if (mean_force.norm() > (1.0 - kLikeGravity) * kStandardGravity_mps2)
    out.level_rate_radps = (rate - up * up.dot(rate)).norm() - tilt * rate.norm();
  for (const Block& b : blocks_) {
    out.gyr_turn_rad += vec(b.turn_rad).norm();
    out.unrest_radps += (vec(b.turn_rad) - mean_turn).norm() / seconds;
  }
  out.gravity_turn_rad = gravity_turn_rad();
  out.gyr_noise_radps = std::sqrt(usual_gyr_noise2());
  out.acc_noise_share = std::sqrt(acc_noise2) / mean_force.norm();
  return out;
}

}  // namespace stillpoint
