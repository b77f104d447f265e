#include "io/text_file.h"

#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
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

namespace {

tl::unexpected<Error> not_writable(const std::string& what, int error) {
  return fail(ErrorKind::kCannotCreate,
              fmt::format("{}: cannot be written: {}; check the folder, its permissions and the disk", what,
                          std::strerror(error)));
}

}  // namespace

Result<void> expect_writable(const std::string& path) {
  namespace fs = std::filesystem;
  if (path.empty() || path == "-") return {};
  std::error_code unknown;
  if (fs::is_directory(path, unknown)) return not_writable(path, EISDIR);
  const fs::path folder = fs::path(path).parent_path();
  const std::string asked = fs::exists(path, unknown) ? path : folder.empty() ? "." : folder.string();
  if (access(asked.c_str(), W_OK) != 0) return not_writable(path, errno);
  return {};
}

Result<void> write_text_file(const std::string& path, std::string_view text) {
  const bool standard = path == "-";
  std::FILE* file = standard ? stdout : std::fopen(path.c_str(), "wb");
  bool whole = file != nullptr && std::fwrite(text.data(), 1, text.size(), file) == text.size();
  if (file != nullptr) whole = (standard ? std::fflush(file) : std::fclose(file)) == 0 && whole;
  if (whole) return {};
  return not_writable(standard ? "standard output" : path, errno);
}

}  // namespace stillpoint::io
