/// Faults of the digital path from converter to file: rows that one triad repeats by chance, single bits that flip,
/// codes that a converter never gives. Each on plain columns.
#pragma once
#include "diagnosis/forensics/detail.h"

namespace stillpoint::diag::detail {

/// Rows on which one triad alone repeats its last reading, far more often than its lattice makes likely and at no fixed
/// period. Empty: none.
[[nodiscard]] std::vector<std::size_t> find_random_repeats(std::span<const Axis> axes,
                                                           const std::vector<std::uint8_t>& ignore);

struct BitFlips {
  std::vector<std::size_t> rows{};
  int lowest_bit = 99, highest_bit = 0;
};
/// Single readings that are off their neighbours by a power of two of the lattice's steps, again and again.
[[nodiscard]] std::optional<BitFlips> find_bit_flips(const Axis& axis);

struct MissingCodes {
  int modulus = 0;            ///< of the codes, counted from the lowest
  std::vector<int> absent{};  ///< residues that never occur
  double expected = 0.0;      ///< readings due on the absent codes, by those beside them
};
/// Residues of the codes, modulo a power of two, that never occur although the readings pass them often.
[[nodiscard]] std::optional<MissingCodes> find_missing_codes(const Axis& axis);

}  // namespace stillpoint::diag::detail
