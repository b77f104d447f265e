#include "apps/stillpoint/simulated_log.h"

#include <algorithm>
#include <cstdio>

#include "exchange/import.h"
#include "io/recording_header.h"
#include "io/text_file.h"

namespace stillpoint::app {
namespace {

/// Whether its columns are ours but for a mistake: that is then told, and no other meaning of the file looked for.
bool is_nearly_ours(const std::string& path) {
  const auto text = io::read_text_file(path, "a simulated log");
  if (!text) return false;
  std::string_view left = *text, line = "#";
  for (bool ended = true; !left.empty() && line.starts_with('#');) line = io::strip(io::take_line(left, ended));
  for (std::size_t start = 0, end = 0; start < line.size(); start = end + 1) {
    end = std::min(line.find(',', start), line.size());
    const auto column = io::known_column(io::strip(line.substr(start, end - start)));
    if (column && column->group != io::kTimeGroup) return true;
  }
  return false;
}

}  // namespace

Result<io::Recording> read_simulated_log(const std::string& path, const std::string& map) {
  auto own = io::read_recording(path, io::OnMalformedRow::kCount);
  if (map.empty() && (own || own.error().kind == ErrorKind::kNoInput || is_nearly_ours(path))) return own;
  exchange::ImportOptions options;
  if (!map.empty()) {
    auto columns = exchange::read_column_map(map);
    if (!columns) return tl::unexpected(columns.error());
    options.map = std::move(*columns);
  }
  auto imported = exchange::import_recording(path, options);
  if (!imported) return tl::unexpected(map.empty() ? own.error() : imported.error());
  for (const auto& reason : imported->reasons) std::fprintf(stderr, "%s\n", reason.c_str());
  return std::move(imported->recording);
}

}  // namespace stillpoint::app
