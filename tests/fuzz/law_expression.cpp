/// Laws that users write: a fault at its column, or a tree whose text reads back to the same tree.
#include "laws/expression.h"
#include "tests/fuzz/fuzz.h"

using namespace stillpoint;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto tree = laws::parse(fuzz::text(data, size), laws::standard_drivers());
  if (!tree) {
    fuzz::expect(tree.error().column >= 1 && tree.error().column <= size + 1, "a fault lies in the text",
                 tree.error().what);
    return 0;
  }
  fuzz::taken();
  const std::string written = laws::text(*tree);
  const auto again = laws::parse(written, laws::standard_drivers());
  fuzz::expect(again.has_value(), "what was written reads back", again ? "" : written + "\n" + again.error().what);
  fuzz::expect(laws::text(*again) == written, "what was written means the same", written);
  return 0;
}
