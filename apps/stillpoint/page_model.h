/// What `stillpoint page` remembers of a daemon beyond its last messages: the curves of the last half minute, the
/// rests, and how long the body has lain on which side. All since the page was started.
#pragma once
#include <array>
#include <cstdint>
#include <deque>
#include <limits>
#include <mutex>
#include <optional>

#include "apps/stillpoint/watch_model.h"
#include "core/types.h"

namespace stillpoint::app {

/// One instant of the curves; NaN where no attitude was fresh.
struct CurvePoint {
  double t_s = 0.0;  ///< since the page was started
  Array3 rpy_rad = kUnknown;
  Array3 sigma_rad = kUnknown;
  bool at_rest = false;

  static constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  static constexpr Array3 kUnknown{kNaN, kNaN, kNaN};
};

/// One stretch in which the daemon said that the body lies still.
struct SeenRest {
  double start_s = 0.0;  ///< since the page was started
  double seconds = 0.0;
  Array3 up_body{};  ///< unit vector: where the world's up lies in the body frame
  bool going_on = true;
};

/// 24 equal parts of the sphere of directions: each face of a cube in quarters.
inline constexpr std::size_t kDirections = 24;

/// Part in which a direction lies: 4 * face + 2 * (second > 0) + (first > 0). The faces are +x, -x, +y, -y, +z, -z;
/// first and second are the two other axes in cyclic order. Pre: not zero.
[[nodiscard]] std::size_t part_of_sphere(const Vec3& direction) noexcept;

/// Filled by one thread, read by any.
class PageModel {
 public:
  static constexpr double kCurve_s = 30.0;
  static constexpr std::size_t kRests = 12;  ///< the last ones are kept

  /// `t_s` advances from call to call.
  void take(const WatchState& state, double t_s);
  [[nodiscard]] std::deque<CurvePoint> curve() const;
  [[nodiscard]] std::deque<SeenRest> rests() const;
  /// Seconds of rest with the world's up in each part of the body's sphere.
  [[nodiscard]] std::array<double, kDirections> rested_s() const;

 private:
  void rest(const Vec3& up_body, double t_s, double step_s);

  mutable std::mutex mutex_;
  std::deque<CurvePoint> curve_;
  std::deque<SeenRest> rests_;
  std::array<double, kDirections> rested_s_{};
  double last_s_ = 0.0;
  std::uint64_t last_received_ = 0;
};

}  // namespace stillpoint::app
