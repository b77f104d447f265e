/// Two readings of the magnetometer with a turn of the body between them so short that neither the gyroscope's offset
/// nor the unevenness of the place comes in.
#pragma once
#include <optional>
#include <type_traits>

#include "core/types.h"

namespace stillpoint::fusion {

/// World axes, with the rotation from body to world by the gyroscope.
struct ShortTurn {
  Vec3 before_uT, after_uT;
  Mat3 R_before, R_after;
  [[nodiscard]] Mat3 turn() const noexcept { return R_after - R_before; }
  [[nodiscard]] Vec3 change_uT() const noexcept { return after_uT - before_uT; }
};

/// Cuts the readings into such turns, each from where the last one ended. Plain state.
class ShortTurns {
 public:
  /// One mean reading in world axes, with the mean rotation at these readings.
  [[nodiscard]] std::optional<ShortTurn> observe(const Vec3& world_uT, const Mat3& R_world_body,
                                                 double time_s) noexcept {
    constexpr double kTurn2 = 0.04;  // squared norm of the difference of two rotations, about 0.14 rad
    constexpr double kStill2 = 1e-4;
    constexpr double kLongest_s = 0.5;
    since_s_ += time_s;
    const double turn2 = (R_world_body - mat(R_)).squaredNorm();
    if (begun_ && turn2 < kTurn2 && since_s_ < kLongest_s) return std::nullopt;
    std::optional<ShortTurn> turn;
    if (begun_ && turn2 > kStill2) turn = ShortTurn{vec(world_uT_), world_uT, mat(R_), R_world_body};
    vec(world_uT_) = world_uT;
    mat(R_) = R_world_body;
    since_s_ = 0.0;
    begun_ = true;
    return turn;
  }

  /// The estimated attitude was corrected by this rotation, which is no turn of the body.
  void turn_world(const Mat3& by) noexcept {
    vec(world_uT_) = by * Vec3(vec(world_uT_));
    mat(R_) = by * Mat3(mat(R_));
  }

  /// What comes next is not connected with what was.
  void interrupt() noexcept { begun_ = false; }

 private:
  Array3 world_uT_{};
  Array9 R_{};
  double since_s_ = 0.0;
  bool begun_ = false;
};

static_assert(std::is_trivially_copyable_v<ShortTurns>);

}  // namespace stillpoint::fusion
