/// Learns the calibration from rest windows and says how well it is known. Pure: a function of the windows only.
/// Accelerometer: the ellipsoid of Gietzelt and Zhang with a temperature polynomial, as a Kalman filter
/// (docs/math/temperature.md). Gyroscope: bias with a temperature polynomial; a turn that the windows could not exclude
/// is one unknown of its whole stretch of rest (docs/math/rest.md, R6).
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <type_traits>

#include "calib_online/field_filter.h"
#include "calib_online/gyro_matrix.h"
#include "calib_online/temperature_cells.h"
#include "calib_online/temperature_filter.h"
#include "calib_online/window.h"
#include "core/calibration.h"
#include "core/fields.h"
#include "core/units.h"

namespace stillpoint::calib {

struct GyroMatrixParams {
  double scale_sd = 0.03;
  double cross_sd = 0.02;
  static constexpr auto fields() {
    using P = GyroMatrixParams;
    return std::tuple{
        field("scale_sd", &P::scale_sd, in_range(1e-6, 0.3), "sd of the factory calibration's scale factors"),
        field("cross_sd", &P::cross_sd, in_range(1e-6, 0.3), "sd of its axes' directions, rad")};
  }
};

struct OnlineCalibratorParams {
  double gravity_mps2 = kStandardGravity_mps2;
  AccFilterParams accelerometer;
  GyrFilterParams gyroscope;
  GyroMatrixParams gyro_matrix;
  FieldFilterParams magnetometer;
  std::string temperature_model = "polynomial";
  TemperatureCellsParams temperature_cells;

  static constexpr auto fields() {
    using P = OnlineCalibratorParams;
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

  /// All that is learnt. Plain: written to disk and read back as it is.
  struct State {
    static constexpr std::uint32_t kVersion = 4;
    std::uint32_t version = kVersion;
    std::uint32_t bytes = 0;  ///< sizeof(State) of the writer
    AccFilter::State acc;
    TemperatureCells::State acc_cells{};  ///< in use unless the temperature model is the polynomial
    GyrFilter::State gyr;                 ///< before the present stretch of rest
    std::uint64_t snapshot_version = 0;
    std::int64_t t_ns = 0;
    std::uint32_t acc_windows = 0, gyr_windows = 0;
    bool acc_replaced = false, gyr_replaced = false;  ///< until what is learnt anew is known again
    std::uint8_t stuck = 0, clipped = 0;              ///< bits of SamplePart
    std::array<CalibrationStatus, 3> sound{};         ///< status of acc, gyr, mag but for stuck and clipped
    std::uint32_t acc_rejected_run = 0, gyr_rejected_run = 0, widenings = 0, same_direction = 0;
    std::uint32_t run_windows = 0;  ///< before this one: a run in one direction and within half a cell
    double run_temp_degC = 0.0;     ///< where it began
    double temp_min_degC = 0.0, temp_max_degC = 0.0;
    bool temp_known = false;
    Array3 last_direction{};
    /// Squared errors of the norm, fading: of the factory calibration and of ours before each update.
    double factory_error = 0.0, learnt_error = 0.0, error_weight = 0.0;
    /// The present stretch of rest.
    std::uint32_t stretch_windows = 0;
    std::int64_t stretch_start_ns = 0;
    double stretch_tau = 0.0, stretch_tau2 = 0.0, stretch_temp_degC = 0.0;
    Array3 stretch_rate{};
    Array9 stretch_cov{}, stretch_turn_cov{};
    /// The turns between windows.
    GyroMatrixSums turns;
    double gyr_matrix_sd = 0.0;  ///< of what is published, rms over its elements
    Array3 previous_acc_mps2{};
    double previous_temp_degC = 0.0;
    bool has_previous = false;
    /// The field in turns.
    FieldFilter::State field{};
    std::int64_t field_t_ns = 0, field_published_ns = 0;
  };
  static_assert(std::is_trivially_copyable_v<State>);

  /// Pre: check(params) is empty.
  OnlineCalibrator(const Params& params, const CalibrationSnapshot& factory);

  /// Windows in time order. True when the snapshot changed.
  bool absorb(const Window& window) noexcept;
  /// Turns of the magnetic field, in time order among themselves.
  bool absorb(const FieldTurn& turn) noexcept;
  [[nodiscard]] const CalibrationSnapshot& snapshot() const noexcept { return snapshot_; }

  [[nodiscard]] State state() const noexcept;
  /// False, and nothing changed, when the state is of another layout or holds anything that is not finite.
  bool restore(const State& state) noexcept;
  /// The same from the bytes of one, as a file keeps it.
  bool restore(std::span<const std::byte> state) noexcept;

 private:
  [[nodiscard]] double tau(double temp_degC, const TriadCalibration& factory) const noexcept;
  void predict(std::int64_t t_ns) noexcept;
  bool learn(const Window& window) noexcept;
  void name_fault(std::size_t triad) noexcept;
  bool absorb_acc(const Window& window) noexcept;
  bool absorb_gyr(const Window& window) noexcept;
  bool absorb_turn(const Window& window) noexcept;
  void commit_stretch() noexcept;
  [[nodiscard]] GyrFilter with_stretch() const noexcept;
  enum class TemperatureModel : std::uint8_t { kNone, kCells, kPolynomial };
  /// The nine entries and their covariance at one temperature, by whichever model is chosen.
  using AccEstimate = TemperatureCells::Estimate;
  [[nodiscard]] double slope_variance() const noexcept;
  [[nodiscard]] double window_variance() const noexcept;
  [[nodiscard]] AccEstimate acc_estimate(double temp_degC) const noexcept;
  [[nodiscard]] Vec9 acc_entries(double temp_degC) const noexcept;  ///< the same without its covariance
  [[nodiscard]] AccFilter::Innovation acc_innovation(const Vec3& x, double temp_degC) const noexcept;
  /// `doubt`: how many times larger an outlier's variance is (Huber).
  void learn_acc(const Vec3& x, const Window& window, double variance, double doubt) noexcept;
  void publish_acc(double temp_degC) noexcept;
  void publish_gyr(double temp_degC) noexcept;
  void accelerometer_replaced() noexcept;
  bool publish_gyr_matrix() noexcept;  ///< false: the turns give none
  void publish_mag() noexcept;

  Params params_;
  CalibrationSnapshot factory_;
  CalibrationSnapshot snapshot_;
  TemperatureModel model_;
  AccFilter acc_;
  TemperatureCells cells_;
  GyrFilter gyr_;
  FieldFilter field_;
  State s_;  ///< its filters' states are filled in by state()
};

}  // namespace stillpoint::calib
