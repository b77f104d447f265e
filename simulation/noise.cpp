#include "simulation/noise.h"

#include <cmath>
#include <numbers>

#include "core/units.h"

namespace stillpoint::sim {
namespace {

constexpr double kLongest_s = 1e5;
constexpr double kRatio = 4.0;  // between neighbouring time constants; the ripple of the sum stays below 2 %

/// Stationary, of this standard deviation.
GaussMarkov stationary(double keep, double sd) { return {keep, sd * std::sqrt(1.0 - keep * keep), sd}; }

/// 1/f noise with B = 1.
std::vector<GaussMarkov> flicker_processes(double step_s) {
  const double sd = std::sqrt(std::log(kRatio) / std::numbers::pi);
  std::vector<GaussMarkov> out;
  for (double tau_s = 0.25 * step_s; tau_s < kLongest_s; tau_s *= kRatio)
    out.push_back(stationary(std::exp(-step_s / tau_s), sd));
  return out;
}

}  // namespace

NoiseModel noise_model(const TriadConfig& c, int axis, double step_s) {
  NoiseModel out;
  const double sd = c.noise_sd * c.noise_axes[axis];
  if (c.noise_band_hz > 0.0)
    out.processes.push_back(stationary(std::exp(-kTwoPi * c.noise_band_hz * step_s), sd));
  else
    out.white = sd;
  if (c.bias_instability > 0.0)
    for (const GaussMarkov& p : flicker_processes(step_s))
      out.processes.push_back({p.keep, c.bias_instability * p.drive, c.bias_instability * p.start});
  if (c.random_walk_per_sqrts > 0.0) out.processes.push_back({1.0, std::sqrt(step_s) * c.random_walk_per_sqrts, 0.0});
  return out;
}

FlickerNoise::FlickerNoise(const Vec3& b, double step_s, std::uint64_t seed, const std::string& source)
    : random_(seed, source), b_(b) {
  for (const GaussMarkov& law : flicker_processes(step_s)) processes_.push_back({law, law.start * random_.normal3()});
}

Vec3 FlickerNoise::next() noexcept {
  Vec3 sum = Vec3::Zero();
  for (auto& p : processes_) {
    sum += p.state;
    p.state = p.law.keep * p.state + p.law.drive * random_.normal3();
  }
  return b_.cwiseProduct(sum);
}

RandomWalk::RandomWalk(const Vec3& q, double step_s, std::uint64_t seed, const std::string& source)
    : random_(seed, source), step_(std::sqrt(step_s) * q) {}

Vec3 RandomWalk::next() noexcept {
  Vec3 now = state_;
  state_ += step_.cwiseProduct(random_.normal3());
  return now;
}

/// With pole a the first stage has variance 1 and the second, fed with (1 - a) of it, (1 + a^2) / (1 + a)^2.
BandNoise::BandNoise(double sd, double band_hz, double step_s, std::uint64_t seed, const std::string& source)
    : random_(seed, source), keep_(std::exp(-kTwoPi * band_hz * step_s)) {
  scale_ = sd * (1.0 + keep_) / std::sqrt(1.0 + keep_ * keep_);
  for (double settled = 1.0; settled > 1e-6 && keep_ < 0.9999; settled *= keep_) next();
}

Vec3 BandNoise::next() noexcept {
  first_ = keep_ * first_ + std::sqrt(1.0 - keep_ * keep_) * random_.normal3();
  second_ = keep_ * second_ + (1.0 - keep_) * first_;
  return scale_ * second_;
}

TriadNoise::TriadNoise(const TriadConfig& c, double step_s, std::uint64_t seed, const std::string& sensor)
    : random_(seed, sensor + " noise"), sd_(c.noise_sd * c.noise_axes) {
  if (c.noise_band_hz > 0.0) {
    keep_ = std::exp(-kTwoPi * c.noise_band_hz * step_s);
    state_ = random_.normal3();
  }
  if (c.bias_instability > 0.0)
    instability_.emplace_back(Vec3::Constant(c.bias_instability), step_s, seed, sensor + " instability");
  if (c.random_walk_per_sqrts > 0.0)
    walk_.emplace_back(Vec3::Constant(c.random_walk_per_sqrts), step_s, seed, sensor + " random walk");
}

Vec3 TriadNoise::next() noexcept {
  const Vec3 fresh = random_.normal3();
  state_ = keep_ == 0.0 ? fresh : Vec3(keep_ * state_ + std::sqrt(1.0 - keep_ * keep_) * fresh);
  Vec3 sum = sd_.cwiseProduct(state_);
  for (auto& flicker : instability_) sum += flicker.next();
  for (auto& walk : walk_) sum += walk.next();
  return sum;
}

}  // namespace stillpoint::sim
