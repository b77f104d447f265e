#include "apps/stillpointd/service_manager.h"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstddef>
#include <cstdlib>
#include <cstring>

#include "core/clock.h"

namespace stillpoint::app {
namespace {

std::string taken(const char* name) {
  const char* value = std::getenv(name);
  std::string out = value != nullptr ? value : "";
  unsetenv(name);
  return out;
}

/// A datagram socket that is connected to the address; -1: none. '@' stands for the abstract namespace.
int connected(std::string path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.empty() || path.size() >= sizeof address.sun_path) return -1;
  const auto length = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + path.size());
  if (path[0] == '@') path[0] = '\0';
  std::memcpy(address.sun_path, path.data(), path.size());
  const int fd = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (fd >= 0 && connect(fd, reinterpret_cast<const sockaddr*>(&address), length) == 0) return fd;
  if (fd >= 0) close(fd);
  return -1;
}

}  // namespace

ServiceManager::ServiceManager() : socket_(connected(taken("NOTIFY_SOCKET"))) {
  const std::string pid = taken("WATCHDOG_PID"), us = taken("WATCHDOG_USEC");
  if (pid.empty() || std::atol(pid.c_str()) == getpid()) watchdog_ns_ = 1000 * std::atoll(us.c_str());
}

ServiceManager::~ServiceManager() {
  if (socket_ >= 0) close(socket_);
}

/// Never waits: a service manager that does not read loses a message.
void ServiceManager::send(const std::string& text) const {
  if (socket_ >= 0) ::send(socket_, text.data(), text.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
}

void ServiceManager::reloading() const { send("RELOADING=1\nMONOTONIC_USEC=" + std::to_string(monotonic_ns() / 1000)); }

void ServiceManager::status(const std::string& line) {
  if (line == status_) return;
  status_ = line;
  send("STATUS=" + line);
}

void ServiceManager::alive(std::uint64_t progress) {
  const std::int64_t now_ns = monotonic_ns();
  if (watchdog_ns_ <= 0 || progress == progress_ || now_ns - fed_ns_ < watchdog_ns_ / 4) return;
  progress_ = progress;
  fed_ns_ = now_ns;
  send("WATCHDOG=1");
}

}  // namespace stillpoint::app
