/// The other end of a stream: a descriptor that is opened, waited for, read, and opened again.
#pragma once
#include <cstdint>
#include <span>
#include <utility>

#include "sources/address.h"

namespace stillpoint::sources {

/// Owns a descriptor.
class Descriptor {
 public:
  Descriptor() noexcept = default;
  explicit Descriptor(int fd) noexcept : fd_(fd) {}
  Descriptor(Descriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(fd_, other.fd_);
    return *this;
  }
  ~Descriptor();
  [[nodiscard]] int get() const noexcept { return fd_; }
  [[nodiscard]] bool open() const noexcept { return fd_ >= 0; }
  void reset() noexcept { *this = Descriptor(); }

 private:
  int fd_ = -1;
};

enum class ReadState : std::uint8_t {
  kBytes,
  kNothing,  ///< within the time given
  kClosed,   ///< the other side went; it may come back
  kEnd,      ///< of a file or of standard input
};

class Endpoint {
 public:
  Endpoint(Address address, int baud) noexcept : address_(std::move(address)), baud_(baud) {}

  /// Fails with what the system said and what to do about it (66, 69).
  [[nodiscard]] Result<void> open();
  [[nodiscard]] bool is_open() const noexcept { return stream_.open() || listener_.open(); }
  /// Waits at most so long. No allocation.
  ReadState read(std::span<std::uint8_t> room, int timeout_ms, std::size_t& bytes) noexcept;
  /// Closes what has to be opened anew; one that listens goes on listening.
  void close() noexcept { stream_.reset(); }

  /// Each read is a message of its own.
  [[nodiscard]] bool datagrams() const noexcept { return address_.kind == AddressKind::kUdp; }
  /// A line that is joined in the midst of what it says.
  [[nodiscard]] bool joins_in_midst() const noexcept { return serial_; }

 private:
  [[nodiscard]] Result<void> open_path();
  [[nodiscard]] Result<void> open_socket();
  bool accept_one(int timeout_ms) noexcept;
  [[nodiscard]] bool displaced() const noexcept;

  Address address_;
  int baud_;
  Descriptor stream_, listener_;
  std::int64_t heard_ns_ = 0;  ///< of a client: when it came, or sent its last byte
  bool serial_ = false, file_ = false;
};

}  // namespace stillpoint::sources
