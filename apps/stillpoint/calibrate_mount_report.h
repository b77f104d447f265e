/// What `stillpoint calibrate --mount` says: how each sensor sits, how sure that is, and what would have to be seen for
/// the rest.
#pragma once
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "calib_online/offline/mount_fit.h"

namespace stillpoint::app {

struct MountRun {
  std::vector<std::string> recordings;
  calib::MountParams params;
  calib::MountEvidence evidence;
  calib::MountFit fit;

  [[nodiscard]] bool mirrored() const;
};

/// What is open, and what to do for it, one a line; what mirrors stands here too.
[[nodiscard]] std::vector<std::string> missing(const MountRun& run);
/// `output: mount` and, where gyroscope or magnetometer sit otherwise than the accelerometer, `source: mount`; empty
/// when nothing is known or a sensor mirrors.
[[nodiscard]] std::string mount_yaml(const MountRun& run);
/// schema "stillpoint.mount/1"
[[nodiscard]] nlohmann::ordered_json to_json(const MountRun& run);
void print(const MountRun& run);

}  // namespace stillpoint::app
