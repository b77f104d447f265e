/// What a recording and a baseline simulation say about the same motion: the calibrated readings, what the reference
/// predicts they should be, their difference, and the quantities that physics may be driven by. A row for every sample.
#pragma once
#include <Eigen/Core>
#include <array>
#include <map>
#include <string>
#include <vector>

#include "core/result.h"
#include "core/types.h"
#include "core/units.h"
#include "diagnosis/forensics/forensics.h"
#include "diagnosis/reference/differences.h"
#include "io/recording.h"
#include "simulation/config.h"

namespace stillpoint::diag {

struct AlignedLog;

inline constexpr int kSensors = 3;
inline constexpr double kMotionBand_Hz = 20.0;  ///< hands, limbs and vehicles move below this, tremor included
inline constexpr std::array<const char*, 3> kAxisName{"x", "y", "z"};

/// Everything that a hypothesis may use. Sensor frame unless said otherwise.
struct Signals {
  Eigen::Index n = 0;
  double dt_s = 0.0;     ///< from row to row, in the mean: rows.step_s
  RowTimes rows;         ///< even or stamped, whichever the reference moves by
  double start_s = 0.0;  ///< time of the first sample, of the recording's own clock
  Series t_s;            ///< from the start of the recording
  bool has_orientation = false, has_position = false;
  bool from_log = false;         ///< predicted is what another simulator says
  bool exact_reference = false;  ///< its jitter at rest and its rounding are far below what would disturb the residual
  bool reference_wanders = false;  ///< slowly; what the sensors agree about of it is taken out
  bool has_rest = false;
  double jitter_sd_s = 0.0;                ///< of the times of the rows, where they are white deviations
  std::array<Series3, kSensors> by_times;  ///< what they do, taken out of the residuals; empty: nothing
  double reference_jitter_rad = 0.0;
  double gravity_mps2 = kStandardGravity_mps2, latitude_rad = 0.85;
  Vec3 field_world_uT = Vec3::Zero();
  std::array<bool, kSensors> present{};
  std::array<sim::TriadConfig, kSensors> given;  ///< H and B as configured
  std::array<sim::TriadConfig, kSensors> triad;  ///< the same, H set right as far as the motion tells it
  std::array<Series3, kSensors> reading;         ///< u = H (y - B)
  std::array<Series3, kSensors> predicted;       ///< from the reference
  std::array<Series3, kSensors> residual;        ///< reading - predicted
  std::array<Series3, kSensors>
      edges_of_rests;  ///< of a noisy reference: not in `predicted`, which sums to what moves with them; or empty
  std::array<Series3, kSensors>
      vector;                        ///< best estimate of the true vector: the reference when exact, else the reading
  std::array<Mask, kSensors> muted;  ///< samples that say nothing about this sensor's residual
  std::array<bool, kSensors> unresolved{};  ///< the body vibrates too fast for the reference: kept rows err with it too
  std::array<bool, kSensors> shaken{};      ///< a vibration of the body was told that the reference does not see
  std::array<double, kSensors> noise_sd{};  ///< as configured, of one sample
  std::array<double, kSensors> lattice_step{};  ///< the coarsest axis'; 0: the readings lie on none
  std::array<double, kSensors> band_hz{};       ///< of `vector` where it is the sensor itself; 0: it is not
  Series3 given_rate;                 ///< what effects that the simulation has already do to the gyroscope; empty: none
  Series3 rate, rate_dot;             ///< rad/s, rad/s^2
  std::array<Series3, 3> world_axis;  ///< world x, y, z seen from the sensor: the columns of R'
  Series3 position_m;                 ///< in the world, its mean removed
  Vec3 mean_position_m = Vec3::Zero();
  Series temperature_K, current_A,
      voltage_V;      ///< empty: not recorded. Temperature relative to 25 degC, smoothed over 1 s
  Series3 vibration;  ///< <f_hf^2> of the catalogue, (m/s^2)^2; empty: sampled too slowly, or no vibration there
  std::map<std::string, Series> user;  ///< further columns of the recording, by their names
  Mask rest;
  std::vector<std::string> notices;

  [[nodiscard]] double duration_s() const { return static_cast<double>(n) * dt_s; }
  [[nodiscard]] bool compared(Sensor k) const { return present[k] && residual[k].rows() > 0; }
};

/// Pre: the recording has at least 2 rows. Fails (65) when nothing of it can be compared: no sensor of the simulation
/// in it. `muted` comes from the forensics, one mask a sensor, empty for none. `log`: takes the place of what the
/// reference predicts. `rows_a_frame`: of a reference that is slower than the rows and was interpolated between them.
[[nodiscard]] Result<Signals> make_signals(const io::Recording& recording, const sim::SimulationConfig& simulation,
                                           const std::array<Mask, kSensors>& muted, const AlignedLog* log = nullptr,
                                           Eigen::Index rows_a_frame = 1);

/// Whether `vector` is the sensor's own reading in its band, not what the reference predicts.
[[nodiscard]] bool vector_is_reading(const Signals& s, Sensor k);

/// What a sensor with these numbers reads of a vector, row by row: y = H^-1 u + B.
[[nodiscard]] Series3 uncorrected(const sim::TriadConfig& triad, const Series3& vector);

/// A vector of the body in the axes of the world, row by row, and back. Needs `world_axis`.
[[nodiscard]] Series3 in_world(const Signals& s, const Series3& body);
[[nodiscard]] Series3 in_body(const Signals& s, const Series3& world);

/// Means of `factor` neighbours, for recordings sampled far faster than anything moves. Noise stays white under it.
[[nodiscard]] Signals thinned(const Signals& s, Eigen::Index factor);

}  // namespace stillpoint::diag
