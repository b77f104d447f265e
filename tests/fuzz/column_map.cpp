/// The map of columns that a person writes for a table nobody knows (`import --map`).
#include "exchange/column_map.h"

#include "tests/fuzz/fuzz.h"

using namespace stillpoint;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const fuzz::MemoryFile file(fuzz::text(data, size));
  const auto map = exchange::read_column_map(file.path());
  if (map) fuzz::taken();
  fuzz::expect(map ? !map->sensors.empty() : map.error().message.starts_with(file.path() + ":"),
               "a map holds a sensor, a fault names its file");
  return 0;
}
