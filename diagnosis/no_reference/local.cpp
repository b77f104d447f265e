/// What of the nuisances reaches a few rows only: the attitude from knot to knot.
#include <algorithm>

#include "diagnosis/no_reference/model.h"

namespace stillpoint::diag::detail {

std::size_t SelfConsistency::knot_after(std::size_t row) const {
  return static_cast<std::size_t>(std::upper_bound(knots_.begin(), knots_.end(), row) - knots_.begin());
}

Sparse SelfConsistency::local_columns() const {
  Triplets entries;
  const auto nm = static_cast<long>(mag_rows_.size()), nc = static_cast<long>(cells_.size());
  for (const Turned& reading : turned_)
    put_turn(entries, reading.at, reading.apart, 3 * static_cast<long>(knot_after(reading.row) - 1), reading.by);
  return assembled<Sparse>(3 * nm + 6 * nc, x_.size() - kLegsAt, entries);
}

/// Of every leg from the one before: a walk.
Sparse SelfConsistency::departures() const {
  Triplets entries;
  for (long i = 0; i < x_.size(); ++i) entries.emplace_back(static_cast<int>(i), static_cast<int>(i), 1.0);
  for (long leg = kLegsAt + 3; leg < x_.size(); leg += 3) put_turn(entries, leg, 1, leg - 3, -Mat3::Identity());
  return assembled<Sparse>(x_.size(), x_.size(), entries);
}

}  // namespace stillpoint::diag::detail
