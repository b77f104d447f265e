/// What a terminal may be shown of a file or of a message from the wire.
#pragma once
#include <string>
#include <string_view>

namespace stillpoint::io {

/// A terminal must not be steered by it, nor flooded: for what is not printable ASCII '?', beyond `shown` characters
/// "...".
[[nodiscard]] inline std::string printable(std::string_view text, std::size_t shown = 300) {
  std::string out(text.substr(0, shown));
  for (char& c : out)
    if (const auto byte = static_cast<unsigned char>(c); byte < 0x20 || byte > 0x7e) c = '?';
  return text.size() > shown ? out + "..." : out;
}

/// In single quotes, 60 characters of it.
[[nodiscard]] inline std::string quote(std::string_view text) { return "'" + printable(text, 60) + "'"; }

}  // namespace stillpoint::io
