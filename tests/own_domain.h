/// A DDS domain that no other test of this machine is in while this process lives: a lock on a file in /tmp tells.
#pragma once
#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cstdlib>
#include <string>

namespace stillpoint::test {

/// 1 to 100: higher domains share ports with the system's ephemeral ones.
inline int own_domain() {
  static const int domain = [] {
    for (int k = 0; k < 100; ++k) {
      const int candidate = 1 + (static_cast<int>(getpid()) + k) % 100;
      const std::string path = "/tmp/stillpoint-test-domain-" + std::to_string(candidate);
      const int file = open(path.c_str(), O_CREAT | O_RDWR | O_CLOEXEC, 0666);
      if (file < 0) continue;
      if (flock(file, LOCK_EX | LOCK_NB) == 0) return candidate;  // the file stays open as long as the process lives
      close(file);
    }
    std::abort();
  }();
  return domain;
}

}  // namespace stillpoint::test
