/// Attitude by an error-state Kalman filter around a quaternion: 9D with a magnetometer, 6D without.
/// Its equations, (A1) and on, and what they are taken from: docs/math/attitude.md.
/// The form after Sola, "Quaternion kinematics for the error-state Kalman filter" (2017), sections 5 and 7 (error in
/// the world frame); acceleration seen through bounded motion, in a gyro-fixed frame, after the idea of Laidig and
/// Seel, "VQF: Highly accurate IMU orientation estimation with bias estimation and magnetic disturbance rejection"
/// (2023).
#pragma once
#include <optional>

#include "core/calibration.h"
#include "core/fields.h"
#include "core/types.h"
#include "fusion/attitude_estimate.h"
#include "fusion/denied_rest.h"
#include "fusion/error_state.h"
#include "fusion/field_reference.h"
#include "fusion/hard_iron.h"
#include "fusion/heading_reading.h"
#include "fusion/iron_finder.h"
#include "fusion/motion_scale.h"
#include "fusion/moving_start.h"
#include "fusion/offset_jumps.h"
#include "fusion/rate_bridge.h"
#include "fusion/straight_line.h"
#include "fusion/turn_witness.h"
#include "fusion/two_witnesses.h"

namespace stillpoint::fusion {

/// What is known of the sensor and of the way it is moved. No value depends on the sampling rate.
struct AttitudeFilterParams {
  double gyr_noise_radps_rtHz = 2e-4;
  double gyr_rate_noise_rtHz = 1e-3;
  double gyr_bias_sd_radps = 0.05;
  double gyr_bias_walk_radps_rtHz = 1e-4;
  double gyr_matrix_sd = 0.004;
  double gyr_matrix_unlearnt_sd = 0.01;
  double acc_noise_mps2_rtHz = 0.03;
  double mag_noise_uT = 0.0;
  double acc_bias_sd_mps2 = 0.1;
  double acc_bias_walk_mps2_rtHz = 1e-4;
  double acc_matrix_sd = 0.01;
  double stamp_sd = 0.5;
  double motion_speed_mps = 1.0;
  double motion_radius_m = 10.0;
  double motion_time_s = 0.5;
  double rest_speed_mps = 0.005;
  double rest_rate_radps = 0.001;
  bool use_magnetometer = true;
  double heading_noise_rad = 0.07;
  double heading_noise_time_s = 10.0;
  double heading_disturbance_rad = 0.05;
  double heading_disturbance_time_s = 10.0;
  double heading_doubt_time_s = 2.0;
  double heading_doubt = 0.3;
  FieldReferenceParams field_reference;
  HardIronParams hard_iron;
  double declination_rad = 0.0;
  double prediction_s = 0.0;
  double acc_lag_s = 0.0;
  double update_period_s = 0.05;

  template <class P = AttitudeFilterParams>
  static constexpr auto fields() {
    return std::tuple{
        field("gyr_noise_radps_rtHz", &P::gyr_noise_radps_rtHz, in_range(1e-7, 1.0),
              "white noise density of the gyroscope (angle random walk); the data sheet or an Allan plot has it"),
        field("gyr_rate_noise_rtHz", &P::gyr_rate_noise_rtHz, in_range(0.0, 0.1),
              "the same per rad/s of rate: what jitter, bandwidth and nonlinearity leave; 1e-3 to 3e-3 are consumer "
              "parts"),
        field("gyr_bias_sd_radps", &P::gyr_bias_sd_radps, in_range(0.0, 1.0),
              "bias that the calibration may have left at the start"),
        field("gyr_bias_walk_radps_rtHz", &P::gyr_bias_walk_radps_rtHz, in_range(0.0, 0.1),
              "random walk of that bias, stress and temperature included; small: slow to follow, large: noisy bias"),
        field("gyr_matrix_sd", &P::gyr_matrix_sd, in_range(0.0, 0.1),
              "scale and misalignment error that the calibration may have left, per element; 0: not learnt"),
        field("gyr_matrix_unlearnt_sd", &P::gyr_matrix_unlearnt_sd, in_range(0.0, 0.1),
              "the same of a gyroscope that nobody has calibrated: what exceeds gyr_matrix_sd is not learnt, it is "
              "stated; a calibration that was learnt states its own"),
        field("acc_noise_mps2_rtHz", &P::acc_noise_mps2_rtHz, in_range(1e-6, 10.0),
              "white noise density of the accelerometer, vibration included"),
        field("mag_noise_uT", &P::mag_noise_uT, in_range(0.0, 1e4),
              "white noise of one reading of the magnetometer, beside heading_noise_rad and hard_iron.noise_uT"),
        field("acc_bias_sd_mps2", &P::acc_bias_sd_mps2, in_range(0.0, 5.0),
              "accelerometer bias that the calibration may have left at the start"),
        field("acc_bias_walk_mps2_rtHz", &P::acc_bias_walk_mps2_rtHz, in_range(0.0, 1.0), "random walk of that bias"),
        field(
            "acc_matrix_sd", &P::acc_matrix_sd, in_range(0.0, 0.1),
            "scale and misalignment error of an accelerometer that nobody has calibrated: it leans the attitude by as "
            "much; a calibration that was learnt states its own"),
        field("stamp_sd", &P::stamp_sd, in_range(0.0, 10.0),
              "how far a stamp may be off its reading, in steps: 0.5 for either end of the interval; 0: exact"),
        field("motion_speed_mps", &P::motion_speed_mps, in_range(1e-3, 1e4),
              "typical speed, of a hand or a walk 1; a body that is faster is found out"),
        field("motion_radius_m", &P::motion_radius_m, in_range(1e-3, 1e6),
              "typical distance from the mean position: a room"),
        field("motion_time_s", &P::motion_time_s, in_range(1e-2, 1e4), "time after which the motion is another one"),
        field("rest_speed_mps", &P::rest_speed_mps, in_range(1e-5, 1.0), "speed that is still called rest"),
        field("rest_rate_radps", &P::rest_rate_radps, in_range(1e-6, 0.1), "turn rate that is still called rest"),
        field("use_magnetometer", &P::use_magnetometer, "false: 6D, the heading is relative"),
        field("heading_noise_rad", &P::heading_noise_rad, in_range(1e-4, 1.0),
              "deviation of one magnetic heading: unevenness of the place and what calibration left"),
        field("heading_noise_time_s", &P::heading_noise_time_s, in_range(0.0, 1e4),
              "time after which that deviation is another one: it averages out no faster"),
        field("heading_disturbance_rad", &P::heading_disturbance_rad, in_range(0.0, 3.0),
              "part of the deviation that is followed as a state"),
        field("heading_disturbance_time_s", &P::heading_disturbance_time_s, in_range(0.1, 1e5),
              "time after which that part is another one"),
        field("heading_doubt_time_s", &P::heading_doubt_time_s, in_range(0.01, 1e4),
              "innovations larger than expected for this long make the filter doubt its heading"),
        field("heading_doubt", &P::heading_doubt, in_range(0.0, 10.0),
              "part of the excess that is added to the heading variance; 0: off"),
        field("field_reference", &P::field_reference, "when the magnetic field is the reference field"),
        field("hard_iron", &P::hard_iron, "magnetism fixed to the sensor"),
        field("declination_rad", &P::declination_rad, in_range(-3.15, 3.15),
              "angle from true north to magnetic north, positive when magnetic north lies east"),
        field("prediction_s", &P::prediction_s, in_range(0.0, 0.1),
              "fixed latency to make up for: the published attitude is turned on by rate times this; 0: off"),
        field("acc_lag_s", &P::acc_lag_s, in_range(-0.1, 0.1),
              "the accelerometer's readings are this much older than the gyroscope's of the same stamp"),
        field("update_period_s", &P::update_period_s, in_range(1e-4, 1.0),
              "the covariance runs at this period, the attitude at every sample")};
  }
};

/// Of the sensors, as in AttitudeFilterParams.
struct WhiteNoise {
  double gyr_radps_rtHz, acc_mps2_rtHz, mag_uT;
};

/// One sensor's filter. Copying it copies all its state, and a copy continues bit for bit.
/// step() is wait-free and allocates nothing.
class AttitudeFilter {
 public:
  explicit AttitudeFilter(const AttitudeFilterParams& params = {}) noexcept;

  /// Forgets everything but what know() was told. The heading starts at `heading_rad` (counter-clockwise from east,
  /// ENU) until, and unless, a magnetometer says otherwise; without one it starts at 0.
  void reset(std::optional<double> heading_rad = std::nullopt) noexcept;

  /// One sample in time order; parts it does not hold are bridged. `at_rest` is the rest detector's word for it.
  [[nodiscard]] AttitudeEstimate step(const CalibratedSample& sample, bool at_rest) noexcept;

  /// From here on, in place of that of the parameters.
  void use_noise(const WhiteNoise& noise) noexcept;

  /// How far the calibration of the first samples can be trusted; of any later one rebase() hears.
  void know(const CalibrationSnapshot& calibration) noexcept;

  /// The calibration has changed between two samples: the states are expressed anew, so that corrected rates and
  /// forces stay what they were and no rest evidence counts twice; only a change with temperature passes through.
  void rebase(const CalibrationSnapshot& from, const CalibrationSnapshot& to) noexcept;

  /// From here on samples come in the reverse order, with rates negated and a clock of their own that goes forward.
  /// What was learnt of the sensor and of the attitude serves on.
  void turn_back() noexcept;

  [[nodiscard]] const AttitudeFilterParams& params() const noexcept { return params_; }
  /// The uncertainty of everything estimated, for tests and diagnosis.
  [[nodiscard]] const ErrorState& error_state() const noexcept { return s_.error; }

 private:
  struct Nominal {  ///< the estimate itself; the error state holds its uncertainty
    Array4 q_world_body{1, 0, 0, 0};
    Array3 velocity_mps{}, position_m{};
    Array3 gyr_bias_radps{}, acc_bias_mps2{};
    Array9 gyr_matrix{};  ///< M of (A2), column by column
    double disturbance_rad = 0.0;
  };
  struct Sums {  ///< over the samples since the last covariance step
    MotionSums motion;
    Array9 theta_rad2{};      ///< noise of the rotation, world axes
    Array9 velocity_m2ps2{};  ///< noise of the velocity, world axes
    Array3 rate_radps_s{};    ///< integral of the corrected rate
    Array3 field_uT{};        ///< sum of the readings in world axes
    Array9 field_R{};         ///< sum of R_world_body at these readings
    int fields = 0;
    bool moved = false;  ///< the rest detector said so at least once
  };
  struct Repetition {  ///< for how long a reading has been the same to the last bit
    Array3 last{};
    double time_s = 0.0;
    void note(const Array3& reading, double dt_s) noexcept {
      time_s = reading == last ? time_s + dt_s : 0.0;
      last = reading;
    }
  };
  struct State {
    Nominal x;
    ErrorState error;
    FieldReference field;
    HardIron hard_iron;
    IronFinder iron_finder;
    MotionScale motion_scale;
    MovingStart moving_start;
    RateBridge rate_bridge;
    DeniedRest denied_rest;
    TwoWitnesses witnesses;
    TurnWitness turn_witness;
    OffsetJumps jumps;
    Sums sums;
    std::int64_t t_ns = 0;
    Array9 R_world_body{1, 0, 0, 0, 1, 0, 0, 0, 1};  ///< of x.q_world_body
    Array3 rate_radps{};                             ///< last corrected rate, for bridging
    Array3 force_world_mps2{};                       ///< last one, for bridging
    Array3 last_field_uT{};                          ///< last reading, to tell a held value from a new one
    Array9 iron_rad2{};         ///< what an untrue hard iron may have done to the attitude, world axes
    Array9 unlearnt_rad2{};     ///< and what the gyroscope's matrix has
    double carried_rad2 = 0.0;  ///< (A38) and a vehicle, about each horizontal axis
    Repetition acc_repeats, gyr_repeats;
    StraightLine gyr_line;
    double temp_degC = 25.0;
    double start_heading_rad = 0.0;
    double start_tilt_rad = 0.1;     ///< standard deviation
    Array9 gyr_unlearnt2{};          ///< variance of the gyroscope's matrix beyond what the error state began with
    double magnetic_s = 0.0;         ///< time of trusted magnetic heading so far
    double unmagnetic_s = 1e9;       ///< time since the last trusted one
    double rest_doubt_s = 0.0;       ///< for this long the rest detector is not believed
    double rest_denied_s = 0.0;      ///< for this long the gyroscope has denied it
    double insisted_radps = 0.0;     ///< about the vertical: such a turn the rest detector alone has called an offset
    double insisted_s = 0.0;         ///< for this long now
    double clipped_s = 0.0;          ///< of the gyroscope: for this long now
    double clip_slope_radps2 = 0.0;  ///< with which it came to its limit
    double unclipped_radps = 0.0;
    double since_pause_s = 0.0;
    double denied_s = 0.0;          ///< for this long yet the sensors are not learnt from
    double denied_for_s = 0.0;      ///< for this long they have not been
    double learning_anew_s = 0.0;   ///< for this long yet they are, denied or not
    double since_gyr_jump_s = 1e9;  ///< of its offset
    double since_acc_jump_s = 1e9;
    double since_rest_s = 0.0;    ///< since one that the gyroscope agreed to
    double lies_s = 0.0;          ///< at rest for this long now
    double lean_s = 0.0;          ///< for this long gravity at rest has denied the tilt
    double heading_stress = 0.0;  ///< signed mean square of the normalised heading innovation
    double age_s = 0.0;
    bool heading_given = false;
    bool clock_started = false;
    bool has_attitude = false;
    bool gyr_heard = false;  ///< at the last sample
    bool acc_heard = false;
    bool magnetometer_seen = false;
    bool at_rest = false;
    bool regained = true;  ///< since the last gap
    AttitudeStatus status = AttitudeStatus::kInitializing;
  };

  void set_attitude(const Quat& q_world_body) noexcept;
  void turn_world(const Quat& turn) noexcept;
  void start_from(const Vec3& acc_mps2) noexcept;
  void start_errors() noexcept;
  [[nodiscard]] bool start_in_motion(double time_s) noexcept;
  void forget_sensors() noexcept;
  void judge(const CalibratedSample& sample, bool acc, bool gyr, double dt_s) noexcept;
  void turn(const CalibratedSample& sample, bool usable, double dt_s) noexcept;
  void bridge(const CalibratedSample& sample, bool gyr, bool acc, double dt_s) noexcept;
  void accelerate(const CalibratedSample& sample, bool usable, double dt_s) noexcept;
  void gather_field(const CalibratedSample& sample) noexcept;
  void covariance_step() noexcept;
  void weigh_surprise(double time_s) noexcept;
  void measure_motion(double time_s) noexcept;
  [[nodiscard]] bool turns_are_told(const Vec3& up_body) const noexcept;
  void state_ride() noexcept;
  void hear_witnesses(double time_s) noexcept;
  void judge_jumps(double time_s) noexcept;
  void measure_rest(double time_s) noexcept;
  void arrive() noexcept;
  void doubt_offset() noexcept;
  void forget_tilt(double lean2) noexcept;
  void relearn_bias(const Vec3& rate_radps) noexcept;
  void doubt_insistence(double time_s) noexcept;
  void end_insisting() noexcept;
  void doubt_motion(double time_s, double rest_speed2) noexcept;
  void doubt_tilt(double time_s) noexcept;
  void measure_field(double time_s) noexcept;
  void start_heading(const HeadingReading& reading) noexcept;
  void follow_iron(const Vec3& seen, const Mat3& R_mean, double time_s) noexcept;
  [[nodiscard]] bool heading_unknown() const noexcept;
  [[nodiscard]] ErrorVector taught_by_heading(const HeadingReading& reading, double expected_rad2) const noexcept;
  void measure_heading(const HeadingReading& reading, double time_s) noexcept;
  void inject() noexcept;
  void take_acc_bias(const TriadCalibration& acc) noexcept;
  void take_gyr_matrix(const TriadCalibration& gyr) noexcept;
  [[nodiscard]] AttitudeEstimate estimate(std::int64_t t_ns) const noexcept;

  struct Known {  ///< of the calibration in force: it outlives a reset
    double acc_matrix_sd;
    Array9 gyr_matrix_sd;  ///< column by column
  };

  AttitudeFilterParams params_;
  Known known_;
  State s_;
  static_assert(std::is_trivially_copyable_v<State>);
};

}  // namespace stillpoint::fusion
