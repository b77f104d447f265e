#include "sources/endpoint.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "core/clock.h"
#include "sources/serial.h"

namespace stillpoint::sources {
namespace {

std::string reason(int code) {
  std::string text = std::strerror(code);
  if (code == EACCES || code == EPERM)
    text +=
        "; who may read it is shown by `ls -l`, for a serial line the group is dialout: `sudo usermod -aG dialout "
        "$USER`, then log in again";
  if (code == EBUSY) text += "; another program has it";
  if (code == ECONNREFUSED) text += "; nobody listens there";
  return text;
}

sockaddr_in socket_address(const Address& address) {
  sockaddr_in out{};
  out.sin_family = AF_INET;
  out.sin_port = htons(address.port);
  inet_pton(AF_INET, address.host.c_str(), &out.sin_addr);
  return out;
}

/// Whether it can be read within the time; a signal counts as no.
bool wait_for(int fd, short events, int timeout_ms) noexcept {
  pollfd wanted{fd, events, 0};
  return poll(&wanted, 1, timeout_ms) > 0;
}

constexpr int kConnect_ms = 100;
constexpr int kSocketBuffer_bytes = 1 << 20;
/// The kernel asks a peer that is silent for so long whether it is still there, and gives it up after as many questions
/// without an answer: 5 s in all. We send nothing, so TCP_USER_TIMEOUT would add nothing.
constexpr int kKeepIdle_s = 2, kKeepInterval_s = 1, kKeepProbes = 3;
/// A client that is silent for so long gives its place to one that waits.
constexpr std::int64_t kSilentClient_ns = 2'000'000'000;

/// A peer that loses its power says no farewell. Who is accepted has it from the socket that listens.
void notice_lost_peers(int fd) {
  const auto set = [fd](int level, int option, int value) { setsockopt(fd, level, option, &value, sizeof value); };
  set(SOL_SOCKET, SO_KEEPALIVE, 1);
  set(IPPROTO_TCP, TCP_KEEPIDLE, kKeepIdle_s);
  set(IPPROTO_TCP, TCP_KEEPINTVL, kKeepInterval_s);
  set(IPPROTO_TCP, TCP_KEEPCNT, kKeepProbes);
}

/// A connection is made while nothing else waits, but not for longer than a source may block.
int connect_for_a_while(int fd, const sockaddr_in& to) {
  if (connect(fd, reinterpret_cast<const sockaddr*>(&to), sizeof to) == 0) return 0;
  if (errno != EINPROGRESS) return errno;
  if (!wait_for(fd, POLLOUT, kConnect_ms)) return ETIMEDOUT;
  int code = 0;
  socklen_t size = sizeof code;
  getsockopt(fd, SOL_SOCKET, SO_ERROR, &code, &size);
  return code;
}

}  // namespace

Descriptor::~Descriptor() {
  if (fd_ >= 0) ::close(fd_);
}

Result<void> Endpoint::open() {
  switch (address_.kind) {
    case AddressKind::kStdin:
      stream_ = Descriptor(fcntl(STDIN_FILENO, F_DUPFD_CLOEXEC, 0));
      file_ = true;
      if (!stream_.open()) return fail(ErrorKind::kNoInput, "standard input is closed");
      return {};
    case AddressKind::kPath:
      return open_path();
    default:
      return open_socket();
  }
}

Result<void> Endpoint::open_path() {
  const std::string& path = address_.path;
  // A writer is not waited for here: its absence is no reason to block.
  Descriptor opened(::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC));
  if (!opened.open()) {
    const bool missing = errno == ENOENT || errno == ENXIO || errno == ENODEV;
    return fail(missing ? ErrorKind::kNoInput : ErrorKind::kUnavailable, fmt::format("{}: {}", path, reason(errno)));
  }
  struct stat info {};
  fstat(opened.get(), &info);
  file_ = S_ISREG(info.st_mode);
  serial_ = S_ISCHR(info.st_mode);
  if (S_ISDIR(info.st_mode))
    return fail(ErrorKind::kNoInput, fmt::format("{}: is a folder; name a serial line, a FIFO or a file", path));
  if (serial_)
    if (const std::string fault = set_serial_line(opened.get(), baud_); !fault.empty())
      return fail(ErrorKind::kUnavailable, fmt::format("{}: {}", path, fault));
  stream_ = std::move(opened);
  return {};
}

Result<void> Endpoint::open_socket() {
  if (listener_.open()) return {};
  const bool udp = address_.kind == AddressKind::kUdp;
  Descriptor made(socket(AF_INET, (udp ? SOCK_DGRAM : SOCK_STREAM) | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  const int on = 1;
  const sockaddr_in there = socket_address(address_);
  int code = made.open() ? 0 : errno;
  if (code == 0 && !udp) notice_lost_peers(made.get());
  if (code == 0 && address_.kind == AddressKind::kTcp) {
    code = connect_for_a_while(made.get(), there);
  } else if (code == 0) {
    if (!udp) setsockopt(made.get(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    if (udp) setsockopt(made.get(), SOL_SOCKET, SO_RCVBUF, &kSocketBuffer_bytes, sizeof kSocketBuffer_bytes);
    code = bind(made.get(), reinterpret_cast<const sockaddr*>(&there), sizeof there) == 0 ? 0 : errno;
    if (code == 0 && !udp) code = listen(made.get(), 1) == 0 ? 0 : errno;
  }
  if (code != 0)
    return fail(ErrorKind::kUnavailable, fmt::format("{}:{}: {}", address_.host, address_.port, reason(code)));
  (address_.kind == AddressKind::kTcpListen ? listener_ : stream_) = std::move(made);
  return {};
}

bool Endpoint::accept_one(int timeout_ms) noexcept {
  if (!wait_for(listener_.get(), POLLIN, timeout_ms)) return false;
  stream_ = Descriptor(accept4(listener_.get(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
  heard_ns_ = monotonic_ns();
  return stream_.open();
}

/// A board that was switched off and on comes back as another client, and the kernel may not know yet that the first
/// is gone.
bool Endpoint::displaced() const noexcept {
  return listener_.open() && monotonic_ns() - heard_ns_ > kSilentClient_ns && wait_for(listener_.get(), POLLIN, 0);
}

ReadState Endpoint::read(std::span<std::uint8_t> room, int timeout_ms, std::size_t& bytes) noexcept {
  if (!stream_.open() && listener_.open() && !accept_one(timeout_ms)) return ReadState::kNothing;
  if (!wait_for(stream_.get(), POLLIN, timeout_ms)) return displaced() ? ReadState::kClosed : ReadState::kNothing;
  const ssize_t n = ::read(stream_.get(), room.data(), room.size());
  if (n > 0) {
    bytes = static_cast<std::size_t>(n);
    heard_ns_ = monotonic_ns();
    return ReadState::kBytes;
  }
  if (n < 0 && (errno == EAGAIN || errno == EINTR)) return ReadState::kNothing;
  if (datagrams()) return ReadState::kNothing;  // an empty one, or the error of an earlier one
  return n == 0 && file_ ? ReadState::kEnd : ReadState::kClosed;
}

}  // namespace stillpoint::sources
