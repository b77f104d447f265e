/// The single examinations behind examine_raw_values(), each on plain columns.
#pragma once
#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <vector>

#include "diagnosis/forensics/forensics.h"
#include "diagnosis/forensics/lattice.h"

namespace stillpoint::diag::detail {

/// One axis with what the other examinations need to know of it.
struct Axis {
  std::vector<double> y;  ///< NaN: not measured
  double printed = 0.0;   ///< step of the file's decimals
  double noise_sd = 0.0;  ///< of the simulation; 0: not stated
  Lattice lattice;        ///< of the rows [lattice_first, lattice_last)
  std::size_t lattice_first = 0, lattice_last = 0;
  [[nodiscard]] double grain() const { return std::max(lattice.step, printed); }
};

/// Rows on a rail, with the level as read.
struct Rail {
  double level = 0.0;
  std::vector<std::size_t> rows;
};

/// Fills lattice and its rows: over the whole column, or over a run of blocks when only part of it is quantised.
void examine_lattice(Axis& axis, std::size_t block_rows);

/// Highest (sign +1) or lowest (sign -1) level at which readings pile up while the body moves; none without a pile.
[[nodiscard]] std::optional<Rail> find_rail(const Axis& axis, double sign);

struct ClippedPeaks {
  double level = 0.0, low = 0.0, high = 0.0;      ///< size of the reading at the rail, over all axes
  std::vector<std::pair<int, std::size_t>> rows;  ///< axis and row
};
/// Rails that a factory calibration has pulled apart: the highest peaks of at least two axes are alike to half a
/// percent and stand near a customary range, each rises from far below within a row, and the next lower reading is far
/// off.
[[nodiscard]] std::optional<ClippedPeaks> find_clipped_peaks(std::span<const Axis> axes,
                                                             std::span<const double> ranges);

struct DeadZone {
  double width = 0.0;  ///< median of its posterior
  std::array<double, 2> ci95{};
  std::size_t zeros = 0, first = 0, last = 0;
};
/// Exact zeros with an empty gap around them. The axes of a triad share one width.
[[nodiscard]] std::optional<DeadZone> find_dead_zone(std::span<const Axis> axes);

struct Hold {
  double period_rows = 1.0;
  bool interpolated = false;        ///< every second row is the mean of its neighbours (resampled upstream)
  bool regular = false;             ///< the period is fixed; false: repeats at random
  std::size_t first = 0, last = 0;  ///< rows it spans
  std::vector<std::uint8_t> stale;  ///< per row
};
/// Values of one triad repeated in all three axes. `ignore` marks rows that were duplicated in every sensor.
[[nodiscard]] std::optional<Hold> find_hold(std::span<const Axis> axes, const std::vector<std::uint8_t>& ignore);

/// Rows equal to the row before in every axis of every triad, more often than the lattices make likely.
/// `axes` holds three per triad.
[[nodiscard]] std::vector<std::uint8_t> find_duplicates(std::span<const Axis> axes);

}  // namespace stillpoint::diag::detail
