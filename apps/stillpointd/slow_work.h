/// All that the calibration thread does beside learning: reliable topics, diagnostics, what is said and what is kept.
/// None of it waits: lines, files and the network have threads of their own.
#pragma once
#include <optional>
#include <string>

#include "apps/stillpointd/health_watch.h"
#include "apps/stillpointd/keeper.h"
#include "apps/stillpointd/live_settings.h"
#include "apps/stillpointd/rate_meter.h"
#include "apps/stillpointd/reading_noise.h"
#include "apps/stillpointd/refused_rows.h"
#include "apps/stillpointd/service_manager.h"
#include "apps/stillpointd/source_watch.h"
#include "apps/stillpointd/troubles.h"
#include "apps/stillpointd/wire.h"
#include "calib_online/online_calibrator.h"
#include "io/config.h"
#include "pipeline/calibration_loop.h"

namespace stillpoint::app {

/// What it works with. All of it lives longer.
struct SlowWorkParts {
  const io::DaemonConfig& config;
  const LiveSettings& live;
  Wire& wire;
  calib::OnlineCalibrator& calibrator;
  Keeper* keeper;  ///< null: nothing is kept
  const Troubles& troubles;
  ServiceManager& service;
  sources::ReportCell source;  ///< null: a replay
};

class SlowWork {
 public:
  SlowWork(const SlowWorkParts& parts, const pipeline::Shared& shared);

  void on_sample(const pipeline::Outgoing& sample);
  void on_calibration(const pipeline::Evidence& evidence, const CalibrationSnapshot& snapshot);
  void on_tick(const pipeline::SensorReport& report, std::int64_t now_ns);
  /// Says what the source had to tell since it was asked last.
  void tell_news(const pipeline::SensorReport& report);
  /// Hands on what is not yet on disk.
  void save();

 private:
  [[nodiscard]] bool stale(const pipeline::SensorReport& report, std::int64_t now_ns) const;
  /// Rows come, and none of them gives an attitude any more.
  [[nodiscard]] bool barren(std::int64_t now_ns) const;
  [[nodiscard]] bool too_old(std::int64_t t_ns, std::int64_t now_ns) const;
  void log_neighbours();
  void log_refused_datagrams();
  /// For the log; empty: attitudes come.
  [[nodiscard]] std::string why_stale(const pipeline::SensorReport& report, std::int64_t now_ns) const;
  void log_changes(const pipeline::SensorReport& report, std::int64_t now_ns);
  [[nodiscard]] DiagnosticsMessage diagnostics(const pipeline::SensorReport& report, std::int64_t now_ns,
                                               bool is_stale);

  const SlowWorkParts parts_;
  const io::DaemonConfig& config_;
  pipeline::OutputFrame frame_;  ///< of the ROS 2 topics, as of the attitude
  const pipeline::Shared& shared_;
  SourceWatch watch_;
  HealthWatch health_;
  RefusedRows refused_rows_;
  AttitudeMessage last_;
  ReadingNoise noise_;
  ReadingCovariances covariances_;  ///< once a second
  std::int64_t start_ns_, last_save_ns_, last_attitude_ns_;
  std::uint64_t attitudes_ = 0;
  RateMeter rate_;
  std::uint64_t told_dropped_ = 0, told_answers_late_ = 0, told_clock_steps_ = 0;
  std::uint64_t tell_readings_late_at_ = 1;
  OutletReport outlet_;  ///< once a second
  io::Neighbours told_neighbours_;
  io::RefusedDatagrams told_datagrams_;
  bool unsaved_ = false, told_stale_ = false;
};

static_assert(pipeline::Observer<SlowWork>);

}  // namespace stillpoint::app
