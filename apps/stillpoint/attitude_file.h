/// Attitude as CSV: one row a sample. docs/formats.md, Attitude.
#pragma once
#include <fmt/format.h>

#include "io/text_file.h"
#include "pipeline/stages.h"

namespace stillpoint::app {

/// "ok", or the fault of the gravest state among the sensors that were not simply never there.
[[nodiscard]] std::string_view health_of(const SensorsHealth& health);

class AttitudeFile {
 public:
  [[nodiscard]] static Result<AttitudeFile> create(const std::string& path);
  [[nodiscard]] Result<void> add(const pipeline::Processed& processed);
  /// Nothing is whole before it.
  [[nodiscard]] Result<void> finish();

 private:
  explicit AttitudeFile(io::OutputFile file) : file_(std::move(file)) {}
  [[nodiscard]] Result<void> write();
  io::OutputFile file_;
  fmt::memory_buffer text_;
};

}  // namespace stillpoint::app
