/// Whether a configured source can be there at all, found out before the daemon runs.
#pragma once
#include "core/result.h"
#include "io/source_config.h"

namespace stillpoint::sources {

/// Fails (78) with place, fault and remedy: no source, a missing file, a folder in place of a file, a recording that is
/// none, a simulation without motion, an address that is none. A device that is not there yet is no fault.
[[nodiscard]] Result<void> check_source(const io::SourceConfig& config);

}  // namespace stillpoint::sources
