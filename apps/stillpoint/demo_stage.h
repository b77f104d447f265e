/// What `stillpoint demo` plays: a simulated hand-held sensor, recorded, and the daemon's configuration to replay it.
#pragma once
#include <filesystem>
#include <string>

#include "core/result.h"
#include "io/dds_params.h"
#include "io/recording.h"

namespace stillpoint::app {

struct DemoOptions {
  double seconds = 30.0;
  std::string folder = "demo-out";
  int seed = 1;
  int domain = -1;   ///< -1: one of its own
  std::string json;  ///< file for the result, "-": standard output, empty: none
};

/// What is simulated, where it lies and how it is replayed.
struct DemoStage {
  io::Recording recording;
  std::string config_path;
  io::DdsParams dds;
  double duration_s = 0.0;
};

/// Simulates, and writes into the folder: the recording, the simulation, the same without its effects, and the daemon's
/// configuration. 73 when the folder cannot be written.
[[nodiscard]] Result<DemoStage> prepare_stage(const DemoOptions& options);

/// Where this program lies, and the daemon beside it.
[[nodiscard]] std::filesystem::path program_folder();

}  // namespace stillpoint::app
