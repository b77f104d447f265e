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

tl::unexpected<Error> not_writable(const std::string& path, int error) {
  return fail(ErrorKind::kCannotCreate,
              fmt::format("{}: cannot be written: {}; check the folder, its permissions and the disk",
                          path == "-" ? "standard output" : path, std::strerror(error)));
}

}  // namespace

Result<OutputFile> OutputFile::create(const std::string& path) {
  std::FILE* file = path == "-" ? stdout : std::fopen(path.c_str(), "wb");
  if (file == nullptr) return not_writable(path, errno);
  return OutputFile(path, file);
}

Result<void> OutputFile::write(std::string_view text) {
  if (std::fwrite(text.data(), 1, text.size(), file_.get()) != text.size()) return not_writable(path_, errno);
  return {};
}

Result<void> OutputFile::flush() {
  if (std::fflush(file_.get()) != 0) return not_writable(path_, errno);
  return {};
}

Result<void> write_text_file(const std::string& path, std::string_view text) {
  auto file = OutputFile::create(path);
  if (!file) return tl::unexpected(file.error());
  if (auto written = file->write(text); !written) return written;
  return file->flush();
}

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

}  // namespace stillpoint::io
