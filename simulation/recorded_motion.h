/// Motion from the reference columns of a recording: smoothing splines through orientation and position, exact
/// stillness where the body rested, gaps bridged. How smooth follows from the reference's own noise
/// (reference_noise.h).
#pragma once
#include <memory>
#include <utility>
#include <vector>

#include "core/result.h"
#include "simulation/motion.h"
#include "simulation/smoothing_spline.h"

namespace stillpoint::sim {

/// Reference samples at strictly increasing times, finite. `position_m` may be empty (the body turns in place),
/// `moving` may be empty (rest is recognised from the reference itself).
struct ReferenceTrack {
  std::vector<double> t_s;
  std::vector<Quat> q_world_body;
  std::vector<Vec3> position_m;
  std::vector<bool> moving;
};

class RecordedMotion final : public Motion {
 public:
  /// Fails (65) with fewer than ten samples or a gap beyond reason. Time 0 of the motion is the first sample.
  [[nodiscard]] static Result<std::unique_ptr<Motion>> from(ReferenceTrack track);

  [[nodiscard]] MotionState at(double t_s) const noexcept override;
  [[nodiscard]] double duration_s() const noexcept override { return duration_s_; }
  [[nodiscard]] const std::vector<std::pair<double, double>>& rests_s() const noexcept { return rests_s_; }

 private:
  RecordedMotion(SmoothingSpline<4> orientation, SmoothingSpline<3> position,
                 std::vector<std::pair<double, double>> rests_s, double duration_s)
      : duration_s_(duration_s),
        rests_s_(std::move(rests_s)),
        orientation_(std::move(orientation)),
        position_(std::move(position)) {}

  double duration_s_;
  std::vector<std::pair<double, double>> rests_s_;
  SmoothingSpline<4> orientation_;
  SmoothingSpline<3> position_;
};

}  // namespace stillpoint::sim
