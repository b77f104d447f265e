/// A network of its own for a test: loopback and one other interface that leads nowhere, so that a default participant
/// has what it announces itself on and nothing leaves the machine. Only the calling thread and its children are in it.
#pragma once
#include <fcntl.h>
#include <sched.h>
#include <unistd.h>

#include <cstdlib>

namespace stillpoint::test {

class NetworkNamespace {
 public:
  NetworkNamespace() : outside_(open("/proc/thread-self/ns/net", O_RDONLY | O_CLOEXEC)) {
    inside_ = outside_ >= 0 && unshare(CLONE_NEWNET) == 0;
    ready_ = inside_ && std::system(
                            "ip link set lo up && ip link add other type veth peer name far && "
                            "ip link set far up && ip addr add 10.77.0.1/24 dev other && "
                            "ip link set other up multicast on") == 0;
  }
  ~NetworkNamespace() {
    if (inside_) setns(outside_, CLONE_NEWNET);
    if (outside_ >= 0) close(outside_);
  }
  NetworkNamespace(const NetworkNamespace&) = delete;
  NetworkNamespace& operator=(const NetworkNamespace&) = delete;
  /// False: the rights or the tool `ip` are missing here.
  [[nodiscard]] bool ready() const { return ready_; }

 private:
  int outside_;
  bool inside_ = false, ready_ = false;
};

}  // namespace stillpoint::test
