/// Learns the calibration from rest windows and turns of the field, and says how well it is known. Pure: a function of
/// that evidence only. Each sensor has a learner of its own; this one knows the order in which they are told.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <type_traits>

#include "calib_online/acc_learner.h"
#include "calib_online/gyr_learner.h"
#include "calib_online/gyr_matrix_learner.h"
#include "calib_online/mag_learner.h"
#include "calib_online/window.h"
#include "core/calibration.h"
#include "core/fields.h"
#include "core/units.h"

namespace stillpoint::calib {

struct OnlineCalibratorParams {
  double gravity_mps2 = kStandardGravity_mps2;
  AccFilterParams accelerometer;
  GyrFilterParams gyroscope;
  GyroMatrixParams gyro_matrix;
  FieldFilterParams magnetometer;
  std::string temperature_model = "polynomial";
  TemperatureCellsParams temperature_cells;

  template <class P = OnlineCalibratorParams>
  static constexpr auto fields() {
    return std::tuple{
        field("gravity_mps2", &P::gravity_mps2, in_range(9.7, 9.9), "local gravity"),
        field("accelerometer", &P::accelerometer, "how good the factory calibration of the accelerometer is"),
        field("gyroscope", &P::gyroscope, "how good the factory calibration of the gyroscope is"),
        field("gyro_matrix", &P::gyro_matrix, "how good the factory calibration of the gyroscope's matrix is"),
        field("magnetometer", &P::magnetometer, "how good the factory calibration of the magnetometer is"),
        field("temperature_model", &P::temperature_model, "of the accelerometer: none, cells or polynomial"),
        field("temperature_cells", &P::temperature_cells, "the cells, where they are chosen"),
    };
  }
};

/// Empty, or what is wrong with the parameters beyond the ranges of their fields.
[[nodiscard]] std::string check(const OnlineCalibratorParams& params);

/// Runs on the calibration thread; allocates nothing, so it may run anywhere.
class OnlineCalibrator {
 public:
  using Params = OnlineCalibratorParams;

  /// All that is learnt. Plain; io/calibration_state.h writes it field by field.
  struct State {
    static constexpr std::uint32_t kVersion = 5;
    std::uint32_t version = kVersion;
    std::uint32_t bytes = 0;  ///< sizeof(State) of the writer
    AccLearner::State acc;
    GyrLearner::State gyr;
    GyrMatrixLearner::State gyr_matrix;
    MagLearner::State mag;
    SeenTemperatures temperatures;
    double gyr_matrix_sd = 0.0;  ///< of what is published, rms over its elements
    std::uint64_t snapshot_version = 0;
    std::int64_t t_ns = 0;
  };
  static_assert(std::is_trivially_copyable_v<State>);

  /// Pre: check(params) is empty.
  OnlineCalibrator(const Params& params, const CalibrationSnapshot& factory);

  /// Windows in time order. True when the snapshot changed.
  bool absorb(const Window& window) noexcept;
  /// Turns of the magnetic field, in time order among themselves.
  bool absorb(const FieldTurn& turn) noexcept;
  /// Turns of known angle, before the windows of the same recording. Each says whether it was used.
  bool absorb(std::span<KnownTurn> turns) noexcept;
  /// What a whole recording teaches of the field (offline/field_again.h), in place of what its turns did one by one.
  void take_field(const MagLearner& field) noexcept;
  [[nodiscard]] const MagLearner& field() const noexcept { return mag_; }
  /// The gyroscope's matrix with its covariance.
  [[nodiscard]] const GyroMatrixFit& gyr_matrix() const noexcept { return gyr_matrix_.stated(); }
  [[nodiscard]] const CalibrationSnapshot& snapshot() const noexcept { return snapshot_; }
  [[nodiscard]] const Params& params() const noexcept { return params_; }
  /// What the learnt stands on.
  [[nodiscard]] const CalibrationSnapshot& factory() const noexcept { return factory_; }

  [[nodiscard]] State state() const noexcept;
  /// False, and nothing changed, when the state is of another layout or holds a number that it cannot have
  /// (state_fields.h).
  bool restore(const State& state) noexcept;
  /// The same from the bytes of one, as a file keeps it.
  bool restore(std::span<const std::byte> state) noexcept;

 private:
  void predict(std::int64_t t_ns) noexcept;
  bool learn(const Window& window) noexcept;
  [[nodiscard]] double direction_sd() const noexcept;
  void name_fault(std::size_t triad) noexcept;

  OnlineCalibratorParams params_;
  CalibrationSnapshot factory_;
  CalibrationSnapshot snapshot_;
  AccLearner acc_;
  GyrLearner gyr_;
  GyrMatrixLearner gyr_matrix_;
  MagLearner mag_;
  SeenTemperatures temperatures_;
  std::int64_t t_ns_ = 0;
  std::uint8_t stuck_ = 0, clipped_ = 0;      ///< bits of SamplePart
  std::array<CalibrationStatus, 3> sound_{};  ///< status of acc, gyr, mag but for stuck and clipped
};

}  // namespace stillpoint::calib
