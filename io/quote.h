/// What a message may quote of a file.
#pragma once
#include <string>
#include <string_view>

namespace stillpoint::io {

/// In single quotes: a terminal must not be steered by it, nor flooded. Beyond 60 characters "...", for what is not
/// printable ASCII '?'.
[[nodiscard]] inline std::string quote(std::string_view text) {
  constexpr std::size_t kShown = 60;
  std::string out(text.substr(0, kShown));
  for (char& c : out)
    if (const auto byte = static_cast<unsigned char>(c); byte < 0x20 || byte > 0x7e) c = '?';
  return "'" + out + (text.size() > kShown ? "...'" : "'");
}

}  // namespace stillpoint::io
