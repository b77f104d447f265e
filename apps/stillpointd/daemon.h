/// Puts one daemon together: source, stages, two threads, DDS, state.
#pragma once
#include "io/config.h"

namespace stillpoint::app {

struct DaemonOptions {
  std::string config_file;       ///< read again on SIGHUP
  int wait_for_subscribers = 0;  ///< the first sample waits until so many subscribers of the attitude are there
};

/// Runs until the source ends (if the configuration says so) or SIGTERM or SIGINT; SIGHUP reads the file again. The
/// exit code of the program. The configuration has a source.
[[nodiscard]] int run_daemon(const io::DaemonConfig& config, const DaemonOptions& options);

}  // namespace stillpoint::app
