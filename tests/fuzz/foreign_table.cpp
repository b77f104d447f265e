/// Tables of other programs: columns, units and times are told from names and values.
#include "exchange/read_table.h"
#include "tests/fuzz/recordings.h"

using namespace stillpoint;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto table = exchange::parse_table(fuzz::text(data, size), "f.csv");
  if (!table) {
    fuzz::expect(table.error().message.starts_with("f.csv:"), "a fault names its file", table.error().message);
    return 0;
  }
  for (const auto& column : table->columns)
    fuzz::expect(column.values.size() == table->rows(), "a column has a value for each row", column.name);
  std::vector<std::string> reasons;
  fuzz::merge_soundly(exchange::read_streams(*table, exchange::guess(*table), reasons));
  return 0;
}
