/// One law that was found, as a finding: its channels, numbers and time, what it cannot be told from, and why.
#pragma once
#include "diagnosis/reference/evidence.h"
#include "diagnosis/result.h"

namespace stillpoint::diag {

/// Bound of the probability that one of all hypotheses that were tried gains as much by chance.
[[nodiscard]] double chance_of(const SensorSearch& search, const Found& f);

/// `index`: among what the search has found.
[[nodiscard]] Finding finding_from(const Signals& s, const SensorSearch& search, std::size_t index,
                                   const Finished& finished, HeldOut held_out);

/// When it acts, in seconds of the recording and in words.
void describe_time(const Signals& s, const Window& window, Finding& out);

}  // namespace stillpoint::diag
