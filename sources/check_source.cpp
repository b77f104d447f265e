#include "sources/check_source.h"

#include <fmt/format.h>

#include <filesystem>

#include "io/recording.h"
#include "io/simulation_yaml.h"
#include "sources/address.h"

namespace stillpoint::sources {
namespace {

namespace fs = std::filesystem;

constexpr const char* kNoMotion = "no 'motion:' block; add one such as motion: {kind: hand, duration_s: 130}";

/// What is wrong, in words; empty: nothing.
std::string fault_of_path(const std::string& path, const char* wanted) {
  std::error_code unknown;
  if (fs::is_directory(path, unknown)) return fmt::format("{}: is a folder; name {}", path, wanted);
  if (!fs::exists(path, unknown)) return fmt::format("{}: there is no such file; name {}", path, wanted);
  return {};
}

std::string fault_of_recording(const io::SourceConfig& config) {
  const std::string& path = config.file;
  if (std::string fault = fault_of_path(path, "a recording (.csv)"); !fault.empty()) return fault;
  const auto recording = io::read_recording(path);
  return recording ? "" : recording.error().message;
}

std::string fault_of_simulation(const io::SourceConfig& config) {
  const std::string& path = config.file;
  if (std::string fault = fault_of_path(path, "a simulation (.yaml)"); !fault.empty()) return fault;
  const auto simulation = io::read_simulation(path);
  if (!simulation) return simulation.error().message;
  return simulation->motion ? "" : fmt::format("{}: {}", path, kNoMotion);
}

std::string fault_of_stream(const io::StreamParams& params) {
  const auto address = parse_address(params.from);
  if (!address) return address.error().message;
  if (address->kind != AddressKind::kPath) return {};
  std::error_code unknown;
  // A device may be plugged in later: the daemon waits for it, and says so.
  return fs::exists(params.from, unknown) ? fault_of_path(params.from, "a serial line, a FIFO or a file") : "";
}

std::string fault_of(const io::SourceConfig& config) {
  std::error_code unknown;
  if (config.wait_for_file && !config.file.empty() && !fs::exists(config.file, unknown)) return {};
  switch (config.kind) {
    case io::SourceKind::kNone:
      return "no 'source:'; name one, such as source: {kind: stream, from: stdin}";
    case io::SourceKind::kRecording:
      return fault_of_recording(config);
    case io::SourceKind::kSimulation:
      return fault_of_simulation(config);
    case io::SourceKind::kStream:
      return fault_of_stream(config.stream);
    default:
      return {};
  }
}

}  // namespace

Result<void> check_source(const io::SourceConfig& config) {
  const std::string fault = fault_of(config);
  if (fault.empty()) return {};
  return fail(ErrorKind::kBadConfig, config.place.empty() ? fault : config.place + ": " + fault);
}

}  // namespace stillpoint::sources
