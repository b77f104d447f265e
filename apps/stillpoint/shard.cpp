#include "apps/stillpoint/shard.h"

#include <fmt/format.h>

#include <charconv>
#include <map>

#include "core/fnv1a.h"
#include "io/quote.h"

namespace stillpoint::app {
namespace {

using SortedJson = nlohmann::json;

std::string list_id(const std::vector<std::string>& sorted) {
  std::uint64_t hash = fnv1a("");
  for (const std::string& name : sorted) hash = fnv1a({name.c_str(), name.size() + 1}, hash);
  return fmt::format("{:016x}", hash);
}

/// What merge_tables relies on; the text says what is wrong.
std::string fault_of(const SortedJson& table) {
  if (!table.is_object() || table.value("schema", SortedJson()) != "stillpoint.estimates/1")
    return "no table of stillpoint.estimates/1, as estimate --json writes for several recordings or --shard";
  if (!table.contains("recordings") || !table["recordings"].is_array()) return "no list of recordings";
  for (const SortedJson& entry : table["recordings"]) {
    if (!entry.is_object() || !entry.contains("recording") || !entry["recording"].is_string())
      return "a recording without a name";
    for (const char* key : kCounts)
      if (entry.contains(key) && !entry[key].is_number_unsigned())
        return fmt::format("{} of {} is no count", key, io::quote(entry["recording"].get<std::string>()));
  }
  if (!table.contains("shard")) return "";
  const SortedJson& shard = table["shard"];
  const auto count = [&shard](const char* key) {
    return shard.is_object() && shard.contains(key) && shard[key].is_number_unsigned() ? shard[key].get<std::size_t>()
                                                                                       : std::size_t{0};
  };
  const bool good = count("index") >= 1 && count("index") <= count("of") && shard.contains("list");
  return good ? "" : "a shard without index, of and list";
}

}  // namespace

Result<Shard> shard_named(const std::string& text) {
  Shard shard;
  const char* const end = text.data() + text.size();
  const auto index = std::from_chars(text.data(), end, shard.index);
  const bool slash = index.ec == std::errc() && index.ptr != end && *index.ptr == '/';
  const auto of = slash ? std::from_chars(index.ptr + 1, end, shard.of) : index;
  constexpr std::size_t kMost = 1'000'000;
  if (!slash || of.ec != std::errc() || of.ptr != end || shard.index < 1 || shard.index > shard.of || shard.of > kMost)
    return fail(ErrorKind::kUsage, fmt::format("--shard {}: must be I/N with I from 1 to N, such as 3/16; jobs that "
                                               "count from 0 add one",
                                               io::quote(text)));
  return shard;
}

SortedJson to_json(const Shard& shard, const std::vector<std::string>& sorted) {
  return {{"index", shard.index}, {"of", shard.of}, {"of_recordings", sorted.size()}, {"list", list_id(sorted)}};
}

Result<MergedTables> merge_tables(const std::vector<NamedTable>& tables) {
  MergedTables out;
  std::map<std::size_t, std::string> file_of_shard;
  std::map<std::string, std::pair<std::string, SortedJson>> by_recording;
  for (const auto& [file, table] : tables)
    if (const std::string fault = fault_of(table); !fault.empty())
      return fail(ErrorKind::kBadData, file + ": " + fault);
  const SortedJson first = tables.front().document.value("shard", SortedJson());
  for (const auto& [file, table] : tables) {
    const SortedJson shard = table.value("shard", SortedJson());
    if (shard.is_null() != first.is_null() ||
        (!shard.is_null() && (shard["of"] != first["of"] || shard["list"] != first["list"])))
      return fail(ErrorKind::kBadData,
                  fmt::format("{} and {} are no parts of one list: the recordings or the number of "
                              "shards differ",
                              tables.front().file, file));
    if (!shard.is_null()) {
      const auto [same, fresh] = file_of_shard.emplace(shard["index"].get<std::size_t>(), file);
      if (!fresh)
        return fail(ErrorKind::kBadData, fmt::format("{} and {} are both shard {} of {}", same->second, file,
                                                     same->first, shard["of"].get<std::size_t>()));
    }
    for (const SortedJson& entry : table["recordings"]) {
      const auto name = entry["recording"].get<std::string>();
      const auto [same, fresh] = by_recording.emplace(name, std::pair(file, entry));
      if (!fresh)
        return fail(ErrorKind::kBadData,
                    fmt::format("{} stands in {} and in {}", io::quote(name), same->second.first, file));
    }
  }
  out.document = {{"schema", "stillpoint.estimates/1"}, {"recordings", SortedJson::array()}};
  SortedJson totals{{"recordings", by_recording.size()}, {"failed", 0}};
  for (const char* key : kCounts) totals[key] = 0;
  for (const auto& [name, from] : by_recording) {
    const SortedJson& entry = from.second;
    if (entry.contains("error")) totals["failed"] = totals["failed"].get<std::size_t>() + 1;
    for (const char* key : kCounts) totals[key] = totals[key].get<std::uint64_t>() + entry.value(key, std::uint64_t{0});
    out.document["recordings"].push_back(entry);
  }
  out.document["totals"] = std::move(totals);
  if (first.is_null()) return out;
  out.of = first["of"].get<std::size_t>();
  for (std::size_t i = 1; i <= out.of; ++i)
    if (!file_of_shard.contains(i)) out.missing.push_back(i);
  out.document["missing_shards"] = out.missing;
  return out;
}

}  // namespace stillpoint::app
