/// A file's text, read and written whole: recordings, configurations, tables of points, results.
#pragma once
#include <string>
#include <string_view>

#include "core/result.h"

namespace stillpoint::io {

/// Fails (66) when it cannot be opened or read, and on a folder or a device, which may have no end. `wanted` says in
/// the message what to name instead, for example "a recording (.csv)".
[[nodiscard]] Result<std::string> read_text_file(const std::string& path, const std::string& wanted);

/// Writes or replaces it; "-" is standard output. Fails (73) with the system's reason: no folder, no right, disk full.
[[nodiscard]] Result<void> write_text_file(const std::string& path, std::string_view text);

/// Fails (73) when a file of this name cannot be written: to be asked before a long computation, not after it. Empty
/// and "-" always can.
[[nodiscard]] Result<void> expect_writable(const std::string& path);

}  // namespace stillpoint::io
