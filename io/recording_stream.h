/// Writes a recording row by row while it happens, so that its length is bounded by the disk and a power cut costs the
/// last second.
#pragma once
#include <cstdint>
#include <cstdio>
#include <map>
#include <memory>
#include <string>

#include "core/result.h"
#include "core/types.h"

namespace stillpoint::io {

class RecordingStream {
 public:
  /// Creates the file and writes its header lines. Fails with 73.
  [[nodiscard]] static Result<RecordingStream> create(const std::string& path,
                                                      const std::map<std::string, std::string>& header);

  /// One row with acc, gyr, mag and temperature; what was not measured stays empty. Numbers are written so that reading
  /// gives the same bits. Fails with 73 when the disk is full.
  [[nodiscard]] Result<void> append(const RawSample& sample);
  /// What was appended is in the operating system's hands.
  [[nodiscard]] Result<void> flush();
  [[nodiscard]] std::uint64_t rows() const { return rows_; }

 private:
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  RecordingStream(std::string path, std::FILE* file) : path_(std::move(path)), file_(file) {}

  std::string path_;
  std::unique_ptr<std::FILE, Close> file_;
  std::uint64_t rows_ = 0;
};

}  // namespace stillpoint::io
