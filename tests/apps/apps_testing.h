/// What the tests of the two programs share: a scratch folder, configurations, the recordings that lie outside the
/// project.
#pragma once
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "io/dds_domain.h"
#include "tests/dds/process.h"
#include "tests/scratch_folder.h"
#include "tests/source_folder.h"

namespace stillpoint::test {

inline void write_file(const std::string& path, const std::string& text) { std::ofstream(path) << text; }
inline std::string read_file(const std::string& path) {
  std::ostringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}
inline std::string configs(const std::string& name) { return in_source("configs/") + name; }
inline std::string handheld() { return in_source("../shared/recordings/handheld_9axis/sensor_data.csv"); }

/// Standard error goes into a file; the exit code comes back.
inline int run(const std::string& command, const std::string& stderr_file) {
  Process process({"/bin/sh", "-c", command + " 2>" + stderr_file});
  process.output();
  return process.wait();
}

}  // namespace stillpoint::test
