/// Attitudes against the truth, for `stillpoint demo`.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "core/types.h"
#include "io/config.h"
#include "io/recording.h"

namespace stillpoint::app {

/// Root mean squares of the attitude error as BROAD defines it (Laidig et al. 2021): the rotation q_est q_ref^-1 in the
/// world, whole, about the vertical, and of the vertical.
class AttitudeScore {
 public:
  void add(const Quat& q_world_body, const Quat& truth) {
    const Quat e = q_world_body * truth.conjugate();
    const double total = 2.0 * std::acos(std::min(1.0, std::abs(e.w())));
    const double heading = 2.0 * std::atan2(std::abs(e.z()), std::abs(e.w()));
    const double inclination = 2.0 * std::acos(std::min(1.0, std::hypot(e.w(), e.z())));
    sum_[0] += total * total;
    sum_[1] += heading * heading;
    sum_[2] += inclination * inclination;
    ++count_;
  }
  [[nodiscard]] std::size_t count() const { return count_; }
  [[nodiscard]] double total_rad() const { return rms(0); }
  [[nodiscard]] double heading_rad() const { return rms(1); }
  [[nodiscard]] double inclination_rad() const { return rms(2); }

 private:
  [[nodiscard]] double rms(std::size_t i) const {
    return count_ == 0 ? 0.0 : std::sqrt(sum_[i] / static_cast<double>(count_));
  }
  std::array<double, 3> sum_{};
  std::size_t count_ = 0;
};

/// The row of this time, or the number of rows when there is none.
[[nodiscard]] std::size_t row_at(const io::Recording& recording, std::int64_t t_ns);

/// The reference attitude. Pre: the recording has one, row < size.
[[nodiscard]] Quat truth_at(const io::Recording& recording, std::size_t row);

/// Only the second half of the recording is scored: the first half is the learning.
[[nodiscard]] bool is_scored(const io::Recording& recording, std::size_t row);

/// The recording through the daemon's stages with nothing learnt: neither by the calibration nor by the filter.
[[nodiscard]] AttitudeScore score_without_learning(const io::Recording& recording, const io::DaemonConfig& config);

}  // namespace stillpoint::app
