/// What a law that explains much could be a part of: a further factor, a bend, memory, a regime, another coupling, one
/// factor less; and its numbers looked for anew.
#pragma once
#include <vector>

#include "diagnosis/discovery/grammar.h"

namespace stillpoint::diag {

/// One step away from `best` with its number.
[[nodiscard]] std::vector<Idea> extensions(const Idea& best, double shape, const laws::Columns& drivers);

/// `best` with its number fixed and one of the others open: time constants, thresholds, widths, moments.
[[nodiscard]] std::vector<Idea> reopened(const Idea& best, double shape);

}  // namespace stillpoint::diag
