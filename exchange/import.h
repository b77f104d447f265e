/// Recordings of other programs: which program wrote a file is told from what is in it.
#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "exchange/column_map.h"
#include "exchange/stream.h"

namespace stillpoint::exchange {

struct Preset {
  std::string_view name;
  std::string_view about;
};
/// All that --preset takes.
[[nodiscard]] const std::vector<Preset>& presets();

struct ImportOptions {
  std::string preset;            ///< empty: found out
  std::optional<ColumnMap> map;  ///< instead of a preset
  std::string topic;             ///< of MCAP; empty: the one with most messages
};

/// The file, archive or folder as a recording. Fails with 66, 65; the message says what to do.
[[nodiscard]] Result<Imported> import_recording(const std::string& path, const ImportOptions& options);

}  // namespace stillpoint::exchange
