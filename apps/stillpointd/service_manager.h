/// What systemd is told of the daemon (sd_notify(3)): that it is up, that it lives, what it does. Where nobody listens,
/// without $NOTIFY_SOCKET, nothing is done.
#pragma once
#include <cstdint>
#include <string>

namespace stillpoint::app {

class ServiceManager {
 public:
  /// Reads $NOTIFY_SOCKET, $WATCHDOG_USEC and $WATCHDOG_PID, and takes them out of the environment.
  ServiceManager();
  ~ServiceManager();
  ServiceManager(const ServiceManager&) = delete;
  ServiceManager& operator=(const ServiceManager&) = delete;

  void ready() const { send("READY=1"); }
  void stopping() const { send("STOPPING=1"); }
  void reloading() const;
  /// One line for `systemctl status`; sent when it has changed.
  void status(const std::string& line);
  /// Feeds the watchdog when it is due and `progress` is another number than at the last feed. Who stands still is
  /// killed, and started anew.
  void alive(std::uint64_t progress);

 private:
  void send(const std::string& text) const;
  int socket_ = -1;
  std::int64_t watchdog_ns_ = 0, fed_ns_ = 0;
  std::uint64_t progress_ = 0;
  std::string status_;
};

}  // namespace stillpoint::app
