/// A search and its drivers over means of rows: what the many ideas are looked at on, before few are judged on all.
#pragma once
#include <span>
#include <vector>

#include "diagnosis/discovery/term_scan.h"
#include "diagnosis/reference/selection.h"
#include "laws/evaluate.h"

namespace stillpoint::diag {

/// The drivers over means of so many rows that about `rows` are left.
struct Rows {
  Eigen::Index factor = 1;
  laws::Columns drivers;

  Rows(const Signals& s, const laws::Columns& full, double rows);
};

/// The thinned side of a search, with the noises that candidates are looked at under: the one that the null model
/// leaves, beside its walk; one that has learnt colour from what a smooth model leaves; and a white one. Under the last
/// two a strong law does not hide as memory, under the first what fits only their error does not come first.
struct Thin {
  Signals s;
  Target target, white, null;
  Columns explained;
  std::vector<NoiseModel> noises;
  std::vector<TermScan> all;

  Thin(const Signals& full, const SensorSearch& base, Eigen::Index factor, bool walks);
  Thin(const Thin&) = delete;
  Thin& operator=(const Thin&) = delete;

  /// Half of the time, and what is strong enough to be looked for hides from the null alone.
  [[nodiscard]] std::span<const TermScan> without_null() const { return std::span(all).subspan(1); }
};

}  // namespace stillpoint::diag
