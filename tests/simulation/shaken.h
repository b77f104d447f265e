/// A body that shakes along and about its axes with given tones, for measuring what a sensor makes of them.
#pragma once
#include <array>
#include <vector>

#include "simulation/motion.h"

namespace stillpoint::sim {

/// Acceleration a sin(2 pi f t) along world x and rate a sin(2 pi f t) about z, for each tone, from `from_s` to `to_s`.
class ShakenBody final : public Motion {
 public:
  struct Tone {
    double frequency_hz, acceleration_mps2, rate_radps;
  };
  ShakenBody(std::vector<Tone> tones, double duration_s, double from_s = 0.0, double to_s = 1e9)
      : tones_(std::move(tones)), duration_s_(duration_s), from_s_(from_s), to_s_(to_s) {}

  [[nodiscard]] MotionState at(double t_s) const noexcept override {
    MotionState s;
    if (t_s < from_s_ || t_s > to_s_) return s;
    s.moving = true;
    double angle = 0.0;
    for (const auto& [f, a, w] : tones_) {
      const double k = 2.0 * M_PI * f;
      s.acceleration_mps2.x() += a * std::sin(k * t_s);
      s.rate_radps.z() += w * std::sin(k * t_s);
      s.angular_acceleration_radps2.z() += w * k * std::cos(k * t_s);
      angle -= w / k * std::cos(k * t_s);
    }
    // The accelerometer's axes stay with the world: along x only what is asked for is felt.
    if (tones_.empty() || tones_.front().rate_radps != 0.0) s.q_world_body = Eigen::AngleAxisd(angle, Vec3::UnitZ());
    return s;
  }
  [[nodiscard]] double duration_s() const noexcept override { return duration_s_; }

 private:
  std::vector<Tone> tones_;
  double duration_s_, from_s_, to_s_;
};

}  // namespace stillpoint::sim
