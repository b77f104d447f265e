/// Writes a recording row by row while it happens, so that its length is bounded by the disk and a power cut costs the
/// last second.
#pragma once
#include <cstdint>
#include <map>
#include <string>

#include "core/result.h"
#include "core/types.h"
#include "io/text_file.h"

namespace stillpoint::io {

class RecordingStream {
 public:
  /// Creates the file and writes its header lines. Fails with 73, as everything here, in the way of OutputFile.
  [[nodiscard]] static Result<RecordingStream> create(const std::string& path,
                                                      const std::map<std::string, std::string>& header);

  /// One row with acc, gyr, mag and temperature; what was not measured stays empty. Numbers are written so that reading
  /// gives the same bits.
  [[nodiscard]] Result<void> append(const RawSample& sample);
  /// What was appended is in the operating system's hands.
  [[nodiscard]] Result<void> flush() { return file_.flush(); }
  [[nodiscard]] std::uint64_t rows() const { return rows_; }

 private:
  explicit RecordingStream(OutputFile file) : file_(std::move(file)) {}

  OutputFile file_;
  std::uint64_t rows_ = 0;
};

}  // namespace stillpoint::io
