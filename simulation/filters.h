/// Linear filters inside a sensor, exact for an input that runs straight between two calls.
#pragma once
#include <cmath>
#include <numbers>

#include "core/types.h"

namespace stillpoint::sim {

/// tau dx/dt = u - x. Starts settled on the first input.
template <class Value>
class LowPass {
 public:
  explicit LowPass(double tau_s) : tau_s_(tau_s) {}

  Value next(const Value& input, double step_s) noexcept {
    if (!started_) {
      started_ = true;
      state_ = last_ = input;
    }
    if (step_s != step_s_) {
      step_s_ = step_s;
      keep_ = std::exp(-step_s / tau_s_);
    }
    if (step_s > 0.0) {
      const Value slope = (input - last_) * (1.0 / step_s);
      state_ = state_ * keep_ + last_ * (1.0 - keep_) + slope * (step_s - tau_s_ * (1.0 - keep_));
    }
    last_ = input;
    return state_;
  }

 private:
  double tau_s_, step_s_ = -1.0, keep_ = 0.0;
  bool started_ = false;
  Value state_{}, last_{};
};

/// x'' + 2 zeta wn x' + wn^2 x = wn^2 u with zeta < 1. Starts settled on the first input.
class Resonance {
 public:
  Resonance(double frequency_hz, double zeta) : wn_(2.0 * std::numbers::pi * frequency_hz), zeta_(zeta) {}

  Vec3 next(const Vec3& input, double step_s) noexcept {
    if (!started_) {
      started_ = true;
      position_ = last_ = input;
    }
    if (step_s > 0.0) {
      // Against the particular solution u0 + m s - 2 zeta m / wn the rest rings down freely.
      const Vec3 slope = (input - last_) / step_s;
      const double sigma = zeta_ * wn_;
      if (step_s != step_s_) {
        const double wd = wn_ * std::sqrt(1.0 - zeta_ * zeta_);
        step_s_ = step_s;
        cosine_ = std::exp(-sigma * step_s) * std::cos(wd * step_s);
        sine_ = std::exp(-sigma * step_s) * std::sin(wd * step_s) / wd;
      }
      const Vec3 lag = (2.0 * zeta_ / wn_) * slope;
      const Vec3 z = position_ - last_ + lag, dz = velocity_ - slope;
      position_ = (cosine_ + sigma * sine_) * z + sine_ * dz + input - lag;
      velocity_ = (cosine_ - sigma * sine_) * dz - wn_ * wn_ * sine_ * z + slope;
    }
    last_ = input;
    return position_;
  }

 private:
  double wn_, zeta_;
  double step_s_ = -1.0, cosine_ = 0.0, sine_ = 0.0;  ///< for this step, damping included
  bool started_ = false;
  Vec3 position_ = Vec3::Zero(), velocity_ = Vec3::Zero(), last_ = Vec3::Zero();
};

}  // namespace stillpoint::sim
