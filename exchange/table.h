/// A table of numbers as other programs write them: any separator, decimal commas, quotes, comments, units in names.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"

namespace stillpoint::exchange {

struct Column {
  std::string name;            ///< as in the file, without quotes
  std::int64_t origin = 0;     ///< added to every value: whole numbers too large for a double keep their last digits
  std::vector<double> values;  ///< NaN: empty, or no number
  std::size_t numbers = 0;     ///< how many of them are numbers
};

struct Table {
  std::string name;  ///< the file
  std::vector<Column> columns;
  std::vector<std::size_t> lines;  ///< of each row, for messages

  [[nodiscard]] std::size_t rows() const { return lines.size(); }
  [[nodiscard]] const Column* find(std::string_view column) const;
};

/// Columns without a header are called 1, 2, ... Fails (65) on text that is no table, with the line.
[[nodiscard]] Result<Table> parse_table(std::string_view text, const std::string& name);

}  // namespace stillpoint::exchange
