/// What the harnesses share. A harness is libFuzzer's LLVMFuzzerTestOneInput: bytes that nobody has checked go where a
/// stranger's bytes go. A refusal is an answer; a finding is what ends the program, or what breaks a promise.
#pragma once
#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>

namespace stillpoint::fuzz {

inline std::string_view text(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

/// A promise that does not hold is a finding like a crash.
inline void expect(bool holds, std::string_view promise, std::string_view more = "") {
  if (holds) return;
  std::fprintf(stderr, "promise broken: %.*s\n%.*s\n", static_cast<int>(promise.size()), promise.data(),
               static_cast<int>(more.size()), more.data());
  std::abort();
}

/// How many inputs were more than refused: without any, nothing is tried behind the first check.
inline std::uint64_t inputs_taken = 0;
inline void taken() { ++inputs_taken; }

/// Takes the front of the bytes for choices; 0 where there are none left.
class Choices {
 public:
  Choices(const std::uint8_t* data, std::size_t size) : rest_(text(data, size)) {}
  std::uint8_t byte() {
    const std::string_view one = bytes(1);
    return one.empty() ? std::uint8_t{0} : static_cast<std::uint8_t>(one[0]);
  }
  std::string_view bytes(std::size_t n) {
    const std::string_view front = rest_.substr(0, n);
    rest_.remove_prefix(front.size());
    return front;
  }
  [[nodiscard]] std::string_view rest() const { return rest_; }

 private:
  std::string_view rest_;
};

/// A file of the bytes, for readers that take a path; it lies in memory and is gone with the object.
class MemoryFile {
 public:
  explicit MemoryFile(std::string_view bytes) : fd_(memfd_create("fuzz", MFD_CLOEXEC)) {
    expect(fd_ >= 0 && write(fd_, bytes.data(), bytes.size()) == static_cast<ssize_t>(bytes.size()),
           "the machine gives a file in memory");
  }
  ~MemoryFile() { close(fd_); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  [[nodiscard]] std::string path() const { return "/proc/self/fd/" + std::to_string(fd_); }

 private:
  int fd_;
};

}  // namespace stillpoint::fuzz
