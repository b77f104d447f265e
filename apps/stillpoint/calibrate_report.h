/// What `stillpoint calibrate --recording` says: the calibration with its uncertainty, and what would have to be seen
/// for the rest. Units as in the recording's samples: m/s^2, rad/s (deg/s in the text), uT.
#pragma once
#include <array>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "apps/stillpoint/known_turns.h"
#include "calib_online/online_calibrator.h"
#include "calib_online/window.h"
#include "core/calibration.h"
#include "core/units.h"

namespace stillpoint::app {

/// A sensor that begins to be stuck, clipped or another one.
struct CalibrationFault {
  double t_s;
  const char* sensor;
  CalibrationStatus status;
};

/// What was known at a moment of the recording.
struct CalibrationMoment {
  double t_s;
  CalibrationSnapshot known;
};

/// What rest detection and calibration made of a recording.
struct CalibrationRun {
  std::vector<calib::Window> windows;
  std::map<std::string, double> refused_s;  ///< seconds by reason
  CalibrationSnapshot factory, learnt;
  calib::OnlineCalibrator::State state;
  std::vector<CalibrationFault> faults;       ///< where each begins
  std::array<CalibrationStatus, 3> status{};  ///< of acc, gyr, mag now
  double gravity_mps2 = kStandardGravity_mps2;
  bool gravity_stated = false;
  double duration_s = 0.0;
  double middle_norm_mps2 = 0.0;  ///< median of the readings
  bool has_mag = false;
  std::vector<CalibrationMoment> course;  ///< whenever something was learnt
  std::int64_t begin_ns = 0;
  calib::GyroMatrixFit gyr_matrix;  ///< as learnt, with its covariance
  std::vector<KnownTurnReport> known_turns;
  std::uint32_t refused_without = 0;  ///< turns between rests, before the known turns were told

  /// The middle of a window since the beginning.
  [[nodiscard]] double seconds(const calib::Window& w) const {
    return kSecondsPerNs *
           (0.5 * static_cast<double>(w.t_end_ns - w.t_start_ns) + static_cast<double>(w.t_start_ns - begin_ns));
  }
};

[[nodiscard]] nlohmann::ordered_json to_json(const std::string& path, const CalibrationRun& run);
void print(const std::string& path, const CalibrationRun& run);

}  // namespace stillpoint::app
