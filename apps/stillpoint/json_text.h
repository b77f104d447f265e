/// JSON as the text of a file.
#pragma once
#include <nlohmann/json.hpp>
#include <string>

namespace stillpoint::app {

/// Bytes that are no UTF-8, of a path or of a name on the wire, are replaced: dump() alone would throw. `indent` -1: in
/// one line.
template <class Json>
[[nodiscard]] std::string json_text(const Json& document, int indent = 2) {
  return document.dump(indent, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace stillpoint::app
