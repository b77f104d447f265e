#include "apps/stillpoint/simulated_log.h"

#include <cstdio>

#include "exchange/import.h"

namespace stillpoint::app {

Result<io::Recording> read_simulated_log(const std::string& path, const std::string& map) {
  auto own = io::read_recording(path, io::OnMalformedRow::kCount);
  if (map.empty() && (own || own.error().kind == ErrorKind::kNoInput)) return own;
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
