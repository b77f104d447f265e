#include "exchange/unpack.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <filesystem>

#include "exchange/bytes.h"
#include "io/text_file.h"

namespace stillpoint::exchange {
namespace {

namespace fs = std::filesystem;
constexpr std::size_t kMost_bytes = std::size_t{4} << 30;
constexpr int kGzipOrZlib = 15 + 32, kRawDeflate = -15;

/// One stream of zlib, unpacked.
Result<std::string> inflated(std::string_view packed, int kind, const std::string& name) {
  z_stream stream{};
  if (inflateInit2(&stream, kind) != Z_OK) return fail(ErrorKind::kBadData, name + ": no memory to unpack it");
  std::string out;
  std::string part(1 << 16, '\0');
  int state = Z_OK;
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));  // zlib reads it only
  stream.avail_in = static_cast<uInt>(packed.size());
  while (state == Z_OK && out.size() <= kMost_bytes) {
    stream.next_out = reinterpret_cast<Bytef*>(part.data());
    stream.avail_out = static_cast<uInt>(part.size());
    state = inflate(&stream, Z_NO_FLUSH);
    out.append(part.data(), part.size() - stream.avail_out);
    if (state == Z_STREAM_END && kind == kGzipOrZlib && stream.avail_in > 0) state = inflateReset(&stream);
  }
  inflateEnd(&stream);
  if (out.size() > kMost_bytes) return fail(ErrorKind::kBadData, name + ": more than 4 GB when unpacked; cut it first");
  if (state != Z_STREAM_END)
    return fail(ErrorKind::kBadData, fmt::format("{}: damaged or cut short after {} bytes unpacked; copy it again from "
                                                 "where it was recorded",
                                                 name, out.size()));
  return out;
}

constexpr std::uint32_t kDirectoryEnd = 0x06054b50, kDirectoryEntry = 0x02014b50;

/// Where the list of a zip's members begins, and how many they are; {0, 0} where there is none.
std::pair<std::size_t, std::size_t> directory_of(const std::string& archive) {
  constexpr std::size_t kEndSize = 22, kLongestComment = 65535;
  if (archive.size() < kEndSize) return {0, 0};
  const std::size_t first = archive.size() - std::min(archive.size(), kEndSize + kLongestComment);
  for (std::size_t at = archive.size() - kEndSize + 1; at-- > first;) {
    Bytes end(std::string_view(archive).substr(at));
    if (end.number<std::uint32_t>() != kDirectoryEnd) continue;
    end.skip(6);
    const auto members = end.number<std::uint16_t>();
    end.skip(4);
    return {end.number<std::uint32_t>(), members};
  }
  return {0, 0};
}

struct Member {
  std::string name;
  std::uint16_t flags = 0, method = 0;
  std::uint32_t crc = 0, packed = 0, offset = 0;
};

Member read_member(Bytes& directory) {
  Member m;
  directory.skip(4);  // versions
  m.flags = directory.number<std::uint16_t>();
  m.method = directory.number<std::uint16_t>();
  directory.skip(4);  // time
  m.crc = directory.number<std::uint32_t>();
  m.packed = directory.number<std::uint32_t>();
  directory.skip(4);
  const auto name = directory.number<std::uint16_t>(), extra = directory.number<std::uint16_t>(),
             comment = directory.number<std::uint16_t>();
  directory.skip(8);
  m.offset = directory.number<std::uint32_t>();
  m.name = directory.take(name);
  directory.skip(std::size_t{extra} + comment);
  return m;
}

/// No member of macOS, nothing hidden, and no picture or film: a data set has thousands of them.
bool wanted(const std::string& name) {
  const std::string leaf = name.substr(name.rfind('/') + 1);
  const std::string end = fs::path(leaf).extension();
  const bool none = end == ".json" || end == ".jpg" || end == ".png" || end == ".mp4" || end == ".m4a";
  return !leaf.empty() && leaf[0] != '.' && !none && name.rfind("__MACOSX", 0) != 0;
}

Result<std::string> unpack_member(const std::string& archive, const Member& m, const std::string& name) {
  if ((m.flags & 1U) != 0) return fail(ErrorKind::kBadData, name + ": encrypted; unpack it with its password first");
  if (m.method != 0 && m.method != 8)
    return fail(ErrorKind::kBadData,
                fmt::format("{}: packed by method {}, only store and deflate are known; unzip it", name, m.method));
  Bytes local(archive);
  local.seek(m.offset);
  local.skip(26);
  const auto name_size = local.number<std::uint16_t>(), extra = local.number<std::uint16_t>();
  local.skip(std::size_t{name_size} + extra);
  const std::string_view packed = local.take(m.packed);
  if (local.ran_out()) return fail(ErrorKind::kBadData, name + ": the archive is cut short; copy it again");
  auto text = m.method == 0 ? Result<std::string>(std::string(packed)) : inflated(packed, kRawDeflate, name);
  if (text && crc32_z(0, reinterpret_cast<const Bytef*>(text->data()), text->size()) != m.crc)
    return fail(ErrorKind::kBadData, name + ": its checksum is wrong; copy the archive again");
  return text;
}

}  // namespace

Result<std::string> gunzip(const std::string& packed, const std::string& name) {
  return inflated(packed, kGzipOrZlib, name);
}

Result<std::vector<NamedText>> unzip(const std::string& archive, const std::string& name) {
  const auto [start, members] = directory_of(archive);
  if (start == 0) return fail(ErrorKind::kBadData, name + ": no list of members; the archive is cut short");
  Bytes directory(archive);
  directory.seek(start);
  std::vector<NamedText> out;
  std::size_t total = 0, packed = 0;
  for (std::size_t i = 0; i < members; ++i) {
    if (directory.number<std::uint32_t>() != kDirectoryEntry)
      return fail(ErrorKind::kBadData, name + ": its list of members is damaged");
    const Member m = read_member(directory);
    if (!wanted(m.name)) continue;
    packed += m.packed;
    if (packed > archive.size())  // members that share their bytes unpack to any size
      return fail(ErrorKind::kBadData, name + ": its members are larger than the archive; it is damaged");
    auto text = unpack_member(archive, m, name + ":" + m.name);
    if (!text) return tl::unexpected(text.error());
    total += text->size();
    if (total > kMost_bytes) return fail(ErrorKind::kBadData, name + ": more than 4 GB when unpacked; cut it first");
    out.push_back({name + ":" + m.name, std::move(*text)});
  }
  return out;
}

Result<std::vector<NamedText>> read_unpacked(const std::string& path) {
  std::error_code unknown;
  std::vector<std::string> files;
  if (fs::is_directory(path, unknown)) {
    constexpr int kDeepest = 4;  // a data set's folder of sequences, mav0/imu0/data.csv
    std::error_code over;
    fs::recursive_directory_iterator at(path, fs::directory_options::skip_permission_denied, over);
    for (; !over && at != fs::recursive_directory_iterator(); at.increment(over)) {
      const bool hidden = !wanted(at->path().filename());
      if (hidden || at.depth() >= kDeepest) at.disable_recursion_pending();
      if (!hidden && at->is_regular_file(unknown)) files.push_back(at->path());
    }
    std::sort(files.begin(), files.end());
  } else {
    files.push_back(path);
  }
  std::vector<NamedText> out;
  for (const auto& file : files) {
    auto text = io::read_text_file(file, "a recording of another program");
    if (!text) return tl::unexpected(text.error());
    if (text->rfind("\x1f\x8b", 0) == 0) {
      text = gunzip(*text, file);
      if (!text) return tl::unexpected(text.error());
    }
    if (text->rfind("PK\x03\x04", 0) == 0) {
      auto members = unzip(*text, file);
      if (!members) return members;
      std::move(members->begin(), members->end(), std::back_inserter(out));
    } else {
      out.push_back({file, std::move(*text)});
    }
  }
  return out;
}

}  // namespace stillpoint::exchange
