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

/// Of a whole message, which may hold names from a file in any script: '?' for each control character but the line
/// feed, those of C1 in UTF-8 among them.
[[nodiscard]] inline std::string without_controls(std::string message) {
  for (std::size_t i = 0; i < message.size(); ++i) {
    const auto at = [&message](std::size_t k) {
      return k < message.size() ? static_cast<unsigned char>(message[k]) : 0U;
    };
    const bool c1 = at(i) == 0xc2 && at(i + 1) >= 0x80 && at(i + 1) <= 0x9f;
    if ((at(i) < 0x20 && message[i] != '\n') || at(i) == 0x7f || c1) message[i] = '?';
    if (c1) message.erase(i + 1, 1);
  }
  return message;
}

/// In single quotes, 60 characters of it.
[[nodiscard]] inline std::string quote(std::string_view text) { return "'" + printable(text, 60) + "'"; }

}  // namespace stillpoint::io
