/// All that the calibration thread does beside learning: reliable topics, diagnostics, log lines, the state file.
#pragma once
#include <optional>
#include <string>

#include "calib_online/online_calibrator.h"
#include "io/config.h"
#include "io/dds_publisher.h"
#include "io/state_file.h"
#include "pipeline/calibration_loop.h"

namespace stillpoint::app {

class SlowWork {
 public:
  /// All of these live longer than this.
  SlowWork(const io::DaemonConfig& config, io::DdsPublisher& publisher, calib::OnlineCalibrator& calibrator,
           const io::StateStore* store, const pipeline::Shared& shared);

  void on_sample(const pipeline::Outgoing& sample);
  void on_calibration(const pipeline::Evidence& evidence, const CalibrationSnapshot& snapshot);
  void on_tick(const pipeline::SensorReport& report, std::int64_t now_ns);
  /// Writes what is not yet on disk.
  void save();

 private:
  [[nodiscard]] bool stale(const pipeline::SensorReport& report, std::int64_t now_ns) const;
  void log_neighbours();
  void log_changes(const pipeline::SensorReport& report, bool is_stale);
  [[nodiscard]] DiagnosticsMessage diagnostics(const pipeline::SensorReport& report, std::int64_t now_ns,
                                               bool is_stale);

  const io::DaemonConfig& config_;
  pipeline::OutputFrame frame_;  ///< of the ROS 2 topics, as of the attitude
  io::DdsPublisher& publisher_;
  calib::OnlineCalibrator& calibrator_;
  const io::StateStore* store_;
  const pipeline::Shared& shared_;
  AttitudeMessage last_;
  std::int64_t start_ns_, last_tick_ns_, last_save_ns_;
  std::uint64_t last_samples_ = 0;
  std::uint64_t told_dropped_ = 0, told_late_ = 0, told_clock_steps_ = 0;
  io::Neighbours told_neighbours_;
  bool unsaved_ = false, told_stale_ = false, told_save_failure_ = false;
};

static_assert(pipeline::Observer<SlowWork>);

}  // namespace stillpoint::app
