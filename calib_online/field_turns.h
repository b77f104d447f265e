/// What the magnetic field does while the sensor turns: pairs of short means of the field with the gyroscope's rotation
/// between them. A field that stays in the world turns back by that rotation; what the body carries does not
/// (docs/math/field.md, F1). The body need not rest. After Zhang, "Two-Step Calibration Methods for Miniature Inertial
/// and Magnetic Sensor Units", eq. (24); the pairwise form is ours.
#pragma once
#include <cstdint>
#include <optional>
#include <type_traits>

#include "calib_online/window.h"
#include "core/calibration.h"

namespace stillpoint::calib {

/// Means are raw readings, each turned to its own middle: what the body carries does not turn, and about the middle
/// that is an error of second order only.
struct FieldTurn {
  std::int64_t t_end_ns = 0;
  double temp_degC = 25.0;
  Array3 before_uT{}, after_uT{};
  Array4 q_before_after{1, 0, 0, 0};  ///< v_before = R(q) v_after
  double noise_uT2 = 0.0;             ///< per axis: what white noise leaves of the difference of the two means
  double path_rad = 0.0;              ///< length of the way, not of its result
  double time_s = 0.0;                ///< from mean to mean
};
static_assert(std::is_trivially_copyable_v<FieldTurn>, "turns cross a ring between the two threads");

/// Finds them in the stream of samples. Runs on the sensor thread: fixed storage, no allocation, no lock. Any rate.
class FieldTurnFinder {
 public:
  /// Takes the next sample in time order. At most two turns a second come out, none while the body does not turn.
  /// `clipped`: bits of SamplePart whose reading sits at the sensor's limit. `mag_turn_rad`: how the body has turned
  /// since the magnetometer's reading, where that is older than the sample.
  std::optional<FieldTurn> push(const RawSample& sample, std::uint8_t clipped, const CalibrationSnapshot& calibration,
                                const Array3& mag_turn_rad) noexcept;

 private:
  struct Block {              ///< readings of a tenth of a second
    Vec3 sum = Vec3::Zero();  ///< calibrated, turned to the block's first sample
    int count = 0;
    Vec3 last = Vec3::Zero();
    double step_sq = 0.0;  ///< of the differences of successive readings: noise without slow parts
    std::int64_t t_start_ns = 0;
    Quat turned = Quat::Identity();  ///< v_first = R(turned) v_now
    Vec3 turned_sum = Vec3::Zero();  ///< of the rotation vectors at the readings
  };
  struct Anchor {  ///< the mean that the next turn begins with
    bool set = false;
    Array3 mean_uT{};  ///< raw
    double noise_uT2 = 0.0;
    std::int64_t t_ns = 0;
    Quat turned = Quat::Identity();  ///< v_anchor = R(turned) v_now
    double path_rad = 0.0;
  };

  void restart() noexcept;
  void turn(const RawSample& sample, const CalibrationSnapshot& calibration) noexcept;
  std::optional<FieldTurn> close_block(const RawSample& sample, const CalibrationSnapshot& calibration) noexcept;

  Block block_;
  Anchor anchor_;
  Array3 last_field_uT_{};
  Vec3 last_rate_ = Vec3::Zero();
  std::int64_t last_t_ns_ = 0;
  bool started_ = false;
};

}  // namespace stillpoint::calib
