/// What of the configuration may change while the daemon runs (SIGHUP), and what a change of the file amounts to.
#pragma once
#include <atomic>
#include <string>
#include <vector>

#include "io/config.h"

namespace stillpoint::app {

/// Written by the main thread, read by the calibration thread.
struct LiveSettings {
  explicit LiveSettings(const io::DaemonConfig& config) { take(config); }
  void take(const io::DaemonConfig& config) {
    stale_after_s = config.stale_after_s;
    save_period_s = config.state.save_period_s;
  }
  std::atomic<double> stale_after_s, save_period_s;
};

struct ConfigChange {
  std::vector<std::string> live, at_next_start;  ///< keys such as dds.domain
  bool dds = false;                              ///< among the live ones
};

/// Keys whose values differ.
[[nodiscard]] ConfigChange compare(const io::DaemonConfig& before, const io::DaemonConfig& after);

}  // namespace stillpoint::app
