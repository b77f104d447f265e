/// A server that speaks the text protocol of iiod 0.24 on the loopback, with devices made up for the tests.
#pragma once
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <functional>
#include <list>
#include <map>
#include <mutex>
#include <set>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "core/clock.h"
#include "pipeline/clock.h"

namespace stillpoint::test {

struct FakeDevice {
  std::string id, name;
  std::string channels_xml;
  double rate_hz = 200.0;
  /// Scan number k as bytes.
  std::function<std::string(std::int64_t k)> scan;
  /// By "channel/name", or "/name" of the device.
  std::map<std::string, std::string> attributes;
  double opening_s = 0.0;  ///< so long it takes to answer to OPEN
};

class FakeIiod {
 public:
  FakeIiod(const std::vector<FakeDevice>& devices, std::uint16_t port)
      : devices_(devices.begin(), devices.end()), port_(port) {
    start();
  }
  ~FakeIiod() { stop(); }
  FakeIiod(const FakeIiod&) = delete;
  FakeIiod& operator=(const FakeIiod&) = delete;

  void start() {
    stopping_ = false;
    listener_ = socket(AF_INET, SOCK_STREAM, 0);
    const int on = 1;
    setsockopt(listener_, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    sockaddr_in at{};
    at.sin_family = AF_INET;
    at.sin_port = htons(port_);
    at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    listening_ = bind(listener_, reinterpret_cast<sockaddr*>(&at), sizeof at) == 0 && listen(listener_, 8) == 0;
    acceptor_ = std::thread([this] { accept_all(); });
  }
  /// As if the power went: every connection is cut.
  void stop() {
    if (!acceptor_.joinable()) return;
    stopping_ = true;
    acceptor_.join();
    for (auto& client : clients_) client.join();
    clients_.clear();
    close(listener_);
  }
  /// A device that its driver makes later: who connects from now on sees it.
  void add(const FakeDevice& device) {
    const std::lock_guard lock(mutex_);
    devices_.push_back(device);
  }
  [[nodiscard]] std::uint16_t port() const { return port_; }
  [[nodiscard]] bool listening() const { return listening_; }
  [[nodiscard]] std::string written(const std::string& what) {
    const std::lock_guard lock(mutex_);
    return written_[what];
  }

 private:
  void accept_all() {
    while (!stopping_) {
      pollfd wanted{listener_, POLLIN, 0};
      if (poll(&wanted, 1, 20) <= 0) continue;
      const int fd = accept(listener_, nullptr, nullptr);
      const int on = 1;
      setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
      clients_.emplace_back([this, fd] { serve(fd); });
    }
  }

  /// Exactly `size` bytes, or up to a line feed for 0. Empty: the end.
  std::string take(int fd, std::size_t size) const {
    std::string text;
    while (!stopping_) {
      pollfd wanted{fd, POLLIN, 0};
      if (poll(&wanted, 1, 20) <= 0) continue;
      char c = 0;
      if (recv(fd, &c, 1, 0) != 1) return {};
      text += c;
      if (size == 0 ? c == '\n' : text.size() == size) return text;
    }
    return {};
  }

  const FakeDevice* find(const std::string& id) const {
    const std::lock_guard lock(mutex_);
    for (const auto& device : devices_)
      if (device.id == id) return &device;
    return nullptr;
  }

  [[nodiscard]] std::string xml() const {
    const std::lock_guard lock(mutex_);
    std::string text = "<?xml version=\"1.0\" encoding=\"utf-8\"?><context name=\"fake\" description=\"fake\">";
    for (const auto& device : devices_) {
      text += "<device id=\"" + device.id + "\" name=\"" + device.name + "\">" + device.channels_xml;
      for (const auto& [key, value] : device.attributes)
        if (key[0] == '/') text += "<attribute name=\"" + key.substr(1) + "\" />";
      text += "</device>";
    }
    return text + "</context>";
  }

  void serve(int fd) {
    std::int64_t scan = 0, start_ns = 0;
    std::string mask;
    for (std::string line; !(line = take(fd, 0)).empty();) {
      std::istringstream words(line);
      std::string command, id;
      words >> command >> id;
      const FakeDevice* device = find(id);
      std::string reply = "-22\n";
      if (command == "VERSION") reply = "0.24.fake000\n";
      if (command == "PRINT") reply = std::to_string(xml().size()) + "\n" + xml() + "\n";
      if (command == "SET") {
        std::string what, value;
        words >> what >> value;
        const std::lock_guard lock(mutex_);
        written_[(device != nullptr ? device->name : "") + " " + what] = value;
      }
      if (command == "TIMEOUT" || command == "SET" || command == "CLOSE") reply = "0\n";
      if (command == "GETTRIG") reply = "-19\n";
      if (command == "EXIT") break;
      if (command == "READ" || command == "WRITE") reply = attribute(fd, command, device, words);
      if (command == "OPEN") {
        std::string samples;
        words >> samples >> mask;
        scan = 0;
        start_ns = monotonic_ns();
        if (device != nullptr) pipeline::sleep_until_ns(start_ns + static_cast<std::int64_t>(1e9 * device->opening_s));
        reply = "0\n";
      }
      if (command == "READBUF" && device != nullptr) {
        std::size_t bytes = 0;
        words >> bytes;
        std::string data;
        while (data.size() < bytes) data += device->scan(scan++);
        pipeline::sleep_until_ns(start_ns +
                                 static_cast<std::int64_t>(1e9 * static_cast<double>(scan) / device->rate_hz));
        reply = std::to_string(data.size()) + "\n" + mask + "\n" + data;
      }
      if (send(fd, reply.data(), reply.size(), MSG_NOSIGNAL) < 0) break;
    }
    close(fd);
  }

  std::string attribute(int fd, const std::string& command, const FakeDevice* device, std::istringstream& words) {
    std::string first, channel, name;
    words >> first;
    if (first == "INPUT")
      words >> channel >> name;
    else
      name = first;
    const std::string key = channel + "/" + name;
    if (command == "WRITE") {
      std::size_t size = 0;
      words >> size;
      const std::string value = take(fd, size);
      const std::lock_guard lock(mutex_);
      written_[(device != nullptr ? device->name : "") + " " + key] = value.c_str();
      return std::to_string(size) + "\n";
    }
    if (device == nullptr || device->attributes.count(key) == 0) return "-2\n";
    const std::string& value = device->attributes.at(key);
    return std::to_string(value.size() + 1) + "\n" + value + std::string(1, '\0') + "\n";
  }

  std::list<FakeDevice> devices_;  // stay where they are when one is added
  std::uint16_t port_;
  int listener_ = -1;
  bool listening_ = false;
  std::atomic<bool> stopping_{false};
  std::thread acceptor_;
  std::list<std::thread> clients_;
  mutable std::mutex mutex_;
  std::map<std::string, std::string> written_;
};

}  // namespace stillpoint::test
