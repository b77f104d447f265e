/// Rows taken from one recording to another.
#pragma once
#include <vector>

#include "io/recording.h"

namespace stillpoint::diag::detail {

/// Whether the column has a value in this row.
template <class Value>
[[nodiscard]] bool there(const std::vector<Value>& column, std::size_t row) {
  return !column.empty() && column[row].allFinite();
}

/// All that is not a column.
[[nodiscard]] io::Recording without_rows(const io::Recording& r);
/// A column that `from` does not have stays away from `to`.
void append_row(const io::Recording& from, std::size_t row, io::Recording& to);
/// A row in which nothing was measured.
void append_empty_row(const io::Recording& from, std::int64_t t_ns, io::Recording& to);

}  // namespace stillpoint::diag::detail
