/// A file's text, read whole, written whole or in parts: recordings, configurations, tables of points, results.
#pragma once
#include <cstdio>
#include <memory>
#include <string>
#include <string_view>

#include "core/result.h"

namespace stillpoint::io {

/// Fails (66) when it cannot be opened or read, and on a folder or a device, which may have no end. `wanted` says in
/// the message what to name instead, for example "a recording (.csv)".
[[nodiscard]] Result<std::string> read_text_file(const std::string& path, const std::string& wanted);

/// A file that is written a part at a time; "-" is standard output. Everything here fails with 73 and the system's
/// reason: no folder, no right, disk full.
class OutputFile {
 public:
  /// Makes it, or empties what is there.
  [[nodiscard]] static Result<OutputFile> create(const std::string& path);
  [[nodiscard]] Result<void> write(std::string_view text);
  /// What was written is in the operating system's hands; without it a full disk may not be noticed.
  [[nodiscard]] Result<void> flush();

 private:
  struct Close {
    void operator()(std::FILE* file) const {
      if (file != stdout) std::fclose(file);
    }
  };
  OutputFile(std::string path, std::FILE* file) : path_(std::move(path)), file_(file) {}
  std::string path_;
  std::unique_ptr<std::FILE, Close> file_;
};

/// Writes or replaces it whole, as an OutputFile.
[[nodiscard]] Result<void> write_text_file(const std::string& path, std::string_view text);

/// Fails (73) when a file of this name cannot be written: to be asked before a long computation, not after it. Empty
/// and "-" always can.
[[nodiscard]] Result<void> expect_writable(const std::string& path);

}  // namespace stillpoint::io
