/// One recording through the daemon's stages, on one thread.
#pragma once
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/result.h"
#include "fusion/attitude_estimate.h"
#include "io/config.h"
#include "io/recording.h"
#include "pipeline/stages.h"

namespace stillpoint::app {

struct EstimateRequest {
  std::string recording, output;
  std::string state;    ///< what is known of the sensor; empty: nothing
  bool smooth = false;  ///< from both sides: pipeline/smooth.h
  bool skip_malformed = false;
};

/// The attitude at one moment, as a page shows it.
struct CoursePoint {
  double t_s;
  fusion::AttitudeEstimate attitude;
  AttitudeStatus status;          ///< as it is published
  std::optional<Vec3> off_rad{};  ///< truth less estimate about the world's axes, where a reference is; z is not a
                                  ///< number while the heading is relative
};

/// What is to be told of it.
struct Estimated {
  std::size_t rows = 0, samples = 0;
  double duration_s = 0.0;
  std::size_t degraded_rows = 0;  ///< of another status than ok
  io::RecordingIssues issues;
  fusion::AttitudeEstimate last;
  pipeline::GuardCounts guard;
  std::uint64_t rest_windows = 0;
  CalibrationSnapshot calibration;  ///< of the end
  SensorsHealth health;             ///< of the end
  std::vector<CoursePoint> course;  ///< a thousand moments at most
};

/// Reads, estimates, writes. Remarks on the recording and on the kept state go to standard error.
[[nodiscard]] Result<Estimated> estimate_one(const EstimateRequest& request, const io::DaemonConfig& config);

/// schema "stillpoint.estimate/1"
[[nodiscard]] nlohmann::json to_json(const Estimated& estimated);
[[nodiscard]] std::string to_text(const Estimated& estimated, const EstimateRequest& request);

}  // namespace stillpoint::app
