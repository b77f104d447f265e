/// `--shard I/N`: one job's part of many recordings, the same for every job that is given the same list.
#pragma once
#include <array>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/result.h"

namespace stillpoint::app {

struct Shard {
  std::size_t index = 1, of = 1;  ///< 1 to `of`
};

/// "3/16"; fails with 64.
[[nodiscard]] Result<Shard> shard_named(const std::string& text);

/// Every `of`-th of a sorted list, from the `index`-th on: long recordings of one name spread over the shards.
template <class T>
[[nodiscard]] std::vector<T> part_of(const Shard& shard, const std::vector<T>& sorted) {
  std::vector<T> part;
  for (std::size_t i = shard.index - 1; i < sorted.size(); i += shard.of) part.push_back(sorted[i]);
  return part;
}

/// Of the whole list, so that parts of different lists are not taken for one.
[[nodiscard]] nlohmann::json to_json(const Shard& shard, const std::vector<std::string>& sorted);

/// What a table counts for each recording, and what is summed.
inline constexpr std::array kCounts{"rows",    "samples", "dropped_rows", "gaps",        "refused",
                                    "clipped", "spikes",  "not_finite",   "rest_windows"};

/// Tables of schema "stillpoint.estimates/1" as one with totals, by name of the recording.
struct MergedTables {
  nlohmann::json document;  ///< the same schema, with `totals` and, where shards were merged, `missing_shards`
  std::vector<std::size_t> missing;
  std::size_t of = 0;  ///< shards; 0: the tables were no shards
};
struct NamedTable {
  std::string file;
  nlohmann::json document;
};
/// Fails (65) where a shard or a recording stands in two tables, or tables are no parts of one list.
[[nodiscard]] Result<MergedTables> merge_tables(const std::vector<NamedTable>& tables);

}  // namespace stillpoint::app
