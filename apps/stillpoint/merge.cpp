/// `stillpoint merge`: the tables of an array job's shards as one, with totals.
#include <fmt/format.h>

#include "apps/stillpoint/commands.h"
#include "apps/stillpoint/json_text.h"
#include "apps/stillpoint/options.h"
#include "apps/stillpoint/outcome.h"
#include "apps/stillpoint/shard.h"
#include "io/text_file.h"

namespace stillpoint::app {
namespace {

struct MergeOptions {
  std::vector<std::string> tables;
  JsonOption json;
  std::string csv;
};

/// RFC 4180.
std::string field(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + "\"";
}

std::string csv_of(const nlohmann::json& merged) {
  std::string out = fmt::format("recording,{},error\n", fmt::join(kCounts, ","));
  for (const auto& entry : merged["recordings"]) {
    out += field(entry["recording"].get<std::string>());
    for (const char* column : kCounts)
      out += ',' + (entry.contains(column) ? std::to_string(entry[column].get<std::uint64_t>()) : std::string());
    out += ',' +
           (entry.contains("error")
                ? field(entry["error"].is_string() ? entry["error"].get<std::string>() : entry["error"].dump())
                : std::string()) +
           '\n';
  }
  return out;
}

void print(const nlohmann::json& merged) {
  std::size_t width = 9;
  for (const auto& entry : merged["recordings"])
    width = std::max(width, entry["recording"].get_ref<const std::string&>().size());
  fmt::print("{:<{}}", "recording", width);
  for (const char* column : kCounts) fmt::print(" {:>12}", column);
  fmt::print("\n");
  const auto numbers = [](const nlohmann::json& entry) {
    for (const char* column : kCounts) fmt::print(" {:>12}", entry.value(column, std::uint64_t{0}));
    fmt::print("\n");
  };
  for (const auto& entry : merged["recordings"]) {
    fmt::print("{:<{}}", entry["recording"].get<std::string>(), width);
    if (entry.contains("error"))
      fmt::print(" failed: {}\n", entry["error"].is_string() ? entry["error"].get<std::string>() : "");
    else
      numbers(entry);
  }
  fmt::print("{:<{}}", "all", width);
  numbers(merged["totals"]);
  fmt::print("{} recordings, {} failed\n", merged["totals"]["recordings"].get<std::size_t>(),
             merged["totals"]["failed"].get<std::size_t>());
}

int run_merge(const MergeOptions& o) {
  const std::string json = o.json.file();
  const auto quiet = is_standard_output({json, o.csv});
  if (!quiet) return report(quiet.error());
  std::vector<NamedTable> tables;
  for (const std::string& file : o.tables) {
    const auto text = io::read_text_file(file, "a table of estimate --json");
    if (!text) return report(text.error());
    auto document = nlohmann::json::parse(*text, nullptr, false);
    if (document.is_discarded()) return report({ErrorKind::kBadData, file + ": no JSON; was its job cut short?"});
    tables.push_back({file, std::move(document)});
  }
  const auto merged = merge_tables(tables);
  if (!merged) return report(merged.error());
  if (!*quiet) print(merged->document);
  if (!json.empty())
    if (const auto done = io::write_text_file(json, json_text(merged->document)); !done) return report(done.error());
  if (!o.csv.empty())
    if (const auto done = io::write_text_file(o.csv, csv_of(merged->document)); !done) return report(done.error());
  if (merged->missing.empty()) return 0;
  return report({ErrorKind::kNoInput, fmt::format("{} of {} shards are missing: {}", merged->missing.size(), merged->of,
                                                  fmt::join(merged->missing, ", "))});
}

}  // namespace

void add_merge(CLI::App& app, Run& run) {
  auto* command = app.add_subcommand("merge", "The tables of an array job's shards as one, with totals");
  static MergeOptions o;
  command->add_option("tables", o.tables, "what `estimate --shard I/N --json FILE` wrote")
      ->type_name(kFileType)
      ->required();
  o.json.add(*command, "write the merged table");
  add_file(*command, "--csv", o.csv, "write it as CSV, one line a recording; - is standard output");
  command->callback([&run] { run = [] { return run_merge(o); }; });
}

}  // namespace stillpoint::app
