/// Motion as a chain of rests and bouts: rest poses, hand motion, a worn day. In a bout the body passes smoothly from
/// one resting pose to the next and swings on the way; every bout starts and ends at rest with no step in acceleration.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "simulation/motion.h"

namespace stillpoint::sim {

/// cosine cos(w t) + sine sin(w t), the same frequency in three axes; the vectors give each axis its amplitude and
/// phase.
struct Swing {
  double frequency_radps = 0.0;
  Vec3 cosine = Vec3::Zero(), sine = Vec3::Zero();
};

/// One rest or bout. A rest has no turn, no shift and no swings.
struct Segment {
  double start_s = 0.0, end_s = 0.0;
  bool moving = false;
  Quat from_q_world_body = Quat::Identity();
  Vec3 turn_rad = Vec3::Zero();  ///< rotation vector from the first pose to the last, body frame
  Vec3 from_m = Vec3::Zero(), shift_m = Vec3::Zero();
  double swell_s = 0.5;  ///< the swings grow and fade during this time
  std::array<Swing, 3> rotation{}, translation{};
};

class SegmentedMotion final : public Motion {
 public:
  /// Pre: at least one segment, each starting where the last ended. After the last the body stays.
  explicit SegmentedMotion(std::vector<Segment> segments);
  [[nodiscard]] MotionState at(double t_s) const noexcept override;
  [[nodiscard]] double duration_s() const noexcept override { return segments_.back().end_s; }
  [[nodiscard]] const std::vector<Segment>& segments() const noexcept { return segments_; }

 private:
  std::vector<Segment> segments_;
};

/// `poses` directions of gravity, spread evenly over the sphere (a Fibonacci lattice), in random order, with random
/// yaw.
[[nodiscard]] std::vector<Segment> rest_pose_segments(const MotionConfig& config, std::uint64_t seed);
/// Bouts of hand motion between rests in arbitrary attitudes.
[[nodiscard]] std::vector<Segment> hand_segments(const MotionConfig& config, std::uint64_t seed);
/// A day on the wrist: sleep, desk work, walks, sport; the rests prefer few directions, as an arm does.
[[nodiscard]] std::vector<Segment> worn_day_segments(const MotionConfig& config, std::uint64_t seed);

}  // namespace stillpoint::sim
