/// A file's text, read whole: recordings, configurations, tables of points.
#pragma once
#include <string>

#include "core/result.h"

namespace stillpoint::io {

/// Fails (66) when it cannot be opened or read, and on a folder or a device, which may have no end. `wanted` says in
/// the message what to name instead, for example "a recording (.csv)".
[[nodiscard]] Result<std::string> read_text_file(const std::string& path, const std::string& wanted);

}  // namespace stillpoint::io
