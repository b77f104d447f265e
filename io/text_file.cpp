#include "io/text_file.h"

#include <fmt/format.h>

#include <array>
#include <filesystem>
#include <fstream>

namespace stillpoint::io {

Result<std::string> read_text_file(const std::string& path, const std::string& wanted) {
  namespace fs = std::filesystem;
  std::error_code unknown;
  const fs::file_type kind = fs::status(path, unknown).type();
  std::ifstream file(path, std::ios::binary);
  if (!file)
    return fail(ErrorKind::kNoInput, fmt::format("{}: cannot be opened; check the path and its permissions", path));
  if (kind != fs::file_type::regular && kind != fs::file_type::fifo)
    return fail(ErrorKind::kNoInput, fmt::format("{}: neither a file nor a pipe; name {}", path, wanted));
  std::string text;
  if (kind == fs::file_type::regular) text.reserve(static_cast<std::size_t>(fs::file_size(path, unknown)) + 1);
  std::array<char, 1 << 16> part{};
  while (file.read(part.data(), part.size()) || file.gcount() > 0)
    text.append(part.data(), static_cast<std::size_t>(file.gcount()));
  if (file.bad()) return fail(ErrorKind::kNoInput, fmt::format("{}: cannot be read to its end", path));
  return text;
}

}  // namespace stillpoint::io
