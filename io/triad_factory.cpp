#include "io/triad_factory.h"

#include <fmt/format.h>

namespace stillpoint::io {
namespace {

template <class Row>
std::string list(const Row& v) {
  return fmt::format("[{}, {}, {}]", v[0], v[1], v[2]);
}

}  // namespace

std::string format_fields(const TriadFactory& t) {
  return fmt::format(
      "    bias: {}\n    bias_per_K: {}\n    bias_per_K2: {}\n    temp_ref_degC: {}\n    temp_min_degC: {}\n"
      "    temp_max_degC: {}\n    matrix: [{}, {}, {}]\n",
      list(t.bias), list(t.bias_per_K), list(t.bias_per_K2), t.temp_ref_degC, t.temp_min_degC, t.temp_max_degC,
      list(t.matrix.row(0)), list(t.matrix.row(1)), list(t.matrix.row(2)));
}

}  // namespace stillpoint::io
