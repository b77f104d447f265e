/// The head of a recording's CSV: its "# key: value" lines and the line of column names.
#pragma once
#include <array>
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"
#include "io/recording_columns.h"

namespace stillpoint::io {

/// Where a column's number goes, and what it is multiplied with on the way.
struct RecordingColumn {
  std::optional<std::size_t> field;  ///< of a RecordingRow
  std::optional<std::size_t> user;   ///< of RecordingHeader::user_columns
  double to_si = 1.0;
};

struct RecordingHeader {
  std::map<std::string, std::string> keys;
  std::vector<RecordingColumn> columns;
  std::vector<std::string> user_columns;
  std::vector<std::string> nameless;  ///< no name, or one that another user column has: nobody could ask for them
  std::array<bool, kColumnGroups> present{};
  std::array<bool, kColumnGroups> in_counts{};
  std::size_t lines = 0;  ///< that it takes
};

/// Without blanks and carriage returns at either end.
[[nodiscard]] std::string_view strip(std::string_view text);

/// Takes one line off the text; `ended` is false when the text stops without a newline.
[[nodiscard]] std::string_view take_line(std::string_view& text, bool& ended);

/// Takes the head off the text. Fails (65) with every fault of the names; `file` stands for it in messages.
[[nodiscard]] Result<RecordingHeader> take_header(std::string_view& text, const std::string& file);

}  // namespace stillpoint::io
