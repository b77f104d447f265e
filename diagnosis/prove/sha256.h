/// SHA-256 (OpenSSL), for sealing the truth of a case before it is solved.
#pragma once
#include <string>
#include <string_view>

namespace stillpoint::diag {

/// Hexadecimal digest of the bytes.
[[nodiscard]] std::string sha256(std::string_view bytes);

}  // namespace stillpoint::diag
