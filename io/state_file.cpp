#include "io/state_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <span>

#include "core/fnv1a.h"

namespace stillpoint::io {

class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  ~Descriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  [[nodiscard]] int get() const { return fd_; }

 private:
  int fd_;
};

namespace {

namespace fs = std::filesystem;
constexpr int kFormat = 1;
constexpr std::uintmax_t kLargest = 1 << 20;  // a state has some kilobytes

std::uint64_t checksum(std::span<const std::byte> bytes) {
  return fnv1a({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

std::string header(const std::string& sensor_id, std::span<const std::byte> payload) {
  return fmt::format("stillpoint-state {}\nsensor {}\nbytes {}\nfnv1a64 {:016x}\n\n", kFormat, sensor_id,
                     payload.size(), checksum(payload));
}

constexpr auto kNameAFolder =
    ". Name a folder that can be written under 'state: directory' (in a systemd unit, StateDirectory=)";

tl::unexpected<Error> cannot(const std::string& what, const std::string& path, const std::string& remedy = "") {
  return fail(ErrorKind::kCannotCreate,
              fmt::format("{}: {}: {}; the calibration cannot be kept{}", path, what, std::strerror(errno), remedy));
}

bool write_all(int fd, const char* data, std::size_t size) {
  while (size > 0) {
    const ssize_t written = ::write(fd, data, size);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    data += written;
    size -= static_cast<std::size_t>(written);
  }
  return true;
}

/// Without it a renamed file may be gone after a power loss.
bool sync_folder(const std::string& folder) {
  const Descriptor fd(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  return fd.get() >= 0 && ::fsync(fd.get()) == 0;
}

/// The name of the temporary file, whole on the disk.
Result<std::string> write_temporary(const std::string& path, const std::string& sensor_id,
                                    std::span<const std::byte> payload) {
  const std::string temporary = path + ".tmp";
  const std::string text =
      header(sensor_id, payload) + std::string(reinterpret_cast<const char*>(payload.data()), payload.size());
  const Descriptor fd(::open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0640));
  if (fd.get() < 0) return cannot("cannot be written", temporary);
  if (write_all(fd.get(), text.data(), text.size()) && ::fsync(fd.get()) == 0) return temporary;
  const auto error = cannot("cannot be written whole", temporary);
  ::unlink(temporary.c_str());
  return error;
}

Result<void> put_in_place(const std::string& temporary, const std::string& path) {
  if (::rename(temporary.c_str(), path.c_str()) != 0) return cannot("cannot be renamed", temporary);
  const std::string folder = fs::path(path).parent_path().string();
  if (!sync_folder(folder.empty() ? "." : folder)) return cannot("cannot be synced", folder);
  return {};
}

/// Whether the path still names what was opened.
bool is_file(int descriptor, const std::string& path) {
  struct stat held = {};
  struct stat named = {};
  return ::fstat(descriptor, &held) == 0 && ::stat(path.c_str(), &named) == 0 && held.st_ino == named.st_ino &&
         held.st_dev == named.st_dev;
}

}  // namespace

Result<StateFile> read_state_file(const std::string& path) {
  std::error_code error;
  if (!fs::exists(path, error)) return fail(ErrorKind::kNoInput, path + ": not there");
  // A folder or a device of this name cannot be read to its end.
  const auto size = fs::is_regular_file(path, error) ? fs::file_size(path, error) : kLargest + 1;
  if (error || size > kLargest) return fail(ErrorKind::kBadData, "not a state file, or cut short");
  std::ifstream in(path, std::ios::binary);
  if (!in) return fail(ErrorKind::kBadData, "cannot be read");
  const std::string text{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  if (!text.starts_with("stillpoint-state ")) return fail(ErrorKind::kBadData, "not a state file, or cut short");
  if (!text.starts_with(fmt::format("stillpoint-state {}\n", kFormat)))
    return fail(ErrorKind::kBadData, "of another format");
  const auto end = text.find("\n\n");
  const auto id = text.find("\nsensor ");
  if (end == std::string::npos || id > end) return fail(ErrorKind::kBadData, "not a state file, or cut short");
  StateFile state;
  const auto id_from = id + std::string_view("\nsensor ").size();
  state.sensor_id = text.substr(id_from, text.find('\n', id_from) - id_from);
  const auto bytes = std::as_bytes(std::span(text)).subspan(end + 2);
  state.payload.assign(bytes.begin(), bytes.end());
  if (text.substr(0, end + 2) != header(state.sensor_id, state.payload))
    return fail(ErrorKind::kBadData, "damaged: length or checksum is wrong");
  return state;
}

Result<void> write_state_file(const std::string& path, const StateFile& state) {
  const auto temporary = write_temporary(path, state.sensor_id, state.payload);
  if (!temporary) return tl::unexpected(temporary.error());
  return put_in_place(*temporary, path);
}

StateStore::StateStore(std::string directory, std::string sensor_id, int keep)
    : directory_(std::move(directory)), sensor_id_(std::move(sensor_id)), keep_(keep) {}

std::string StateStore::path(int age) const {
  return (fs::path(directory_) / (age == 0 ? sensor_id_ + ".state" : fmt::format("{}.{}.state", sensor_id_, age)))
      .string();
}

std::string StateStore::lock_file() const { return (fs::path(directory_) / (sensor_id_ + ".lock")).string(); }

Result<void> StateStore::claim() {
  std::error_code error;
  fs::create_directories(directory_, error);
  const std::string file = lock_file();
  auto lock = std::make_shared<const Descriptor>(::open(file.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0640));
  if (lock->get() < 0) return cannot("cannot be written", file, kNameAFolder);
  if (::flock(lock->get(), LOCK_EX | LOCK_NB) != 0)
    return fail(ErrorKind::kUnavailable,
                fmt::format("{}: another stillpointd keeps the calibration of sensor '{}' here; end it, or give this "
                            "one another sensor.id or state.directory",
                            file, sensor_id_));
  // After the lock: until then the file may be one that another daemon is about to rename.
  const std::string temporary = path() + ".tmp";
  if (Descriptor(::open(temporary.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0640)).get() < 0)
    return cannot("cannot be written", temporary, kNameAFolder);
  ::unlink(temporary.c_str());
  lock_ = std::move(lock);
  return {};
}

Result<void> StateStore::save(std::span<const std::byte> payload) {
  if (lock_ && !is_file(lock_->get(), lock_file()))  // somebody removed the folder, or cleared it
    if (auto claimed = claim(); !claimed) return claimed;
  const auto temporary = write_temporary(path(), sensor_id_, payload);
  if (!temporary) return tl::unexpected(temporary.error());
  // A crash between these renames leaves a gap in the ages, never the lack of a good file.
  for (int age = keep_ - 1; age > 0; --age)
    if (::rename(path(age - 1).c_str(), path(age).c_str()) != 0 && errno != ENOENT)
      return cannot("cannot be renamed", path(age - 1));
  return put_in_place(*temporary, path());
}

StateStore::Loaded StateStore::load(const std::function<std::string(std::span<const std::byte>)>& why_not) const {
  Loaded loaded;
  for (int age = 0; age < keep_; ++age) {
    const std::string file = path(age);
    auto state = read_state_file(file);
    if (!state && state.error().kind == ErrorKind::kNoInput) continue;
    const bool another = state && state->sensor_id != sensor_id_;
    const std::string reason = !state    ? state.error().message
                               : another ? "it belongs to another sensor"
                                         : why_not(state->payload);
    if (reason.empty()) {
      loaded.payload = std::move(state->payload);
      loaded.file = file;
      return loaded;
    }
    const std::string aside = file + ".damaged";
    const bool moved = ::rename(file.c_str(), aside.c_str()) == 0;
    loaded.set_aside.push_back(
        fmt::format("{}: {}; {}", file, reason, moved ? "set aside as " + aside : "it could not be renamed"));
  }
  return loaded;
}

}  // namespace stillpoint::io
