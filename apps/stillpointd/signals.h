/// SIGTERM and SIGINT ask the daemon to end, SIGHUP to read its configuration again.
#pragma once
#include <poll.h>
#include <signal.h>

#include <array>
#include <cstring>
#include <optional>
#include <string>

namespace stillpoint::app {

struct Asked {
  enum class What { kEnd, kReload } what = What::kEnd;
  std::string by;  ///< name of the signal
};

/// They are taken here, by the main thread; every thread made later inherits that they are blocked.
class Signals {
 public:
  Signals() {
    sigemptyset(&set_);
    for (const int number : {SIGTERM, SIGINT, SIGHUP}) sigaddset(&set_, number);
    pthread_sigmask(SIG_BLOCK, &set_, nullptr);
    signal(SIGPIPE, SIG_IGN);
    signal(SIGXFSZ, SIG_IGN);  // a file that may not grow is an error of its write, not the end
  }

  /// What came within 50 ms.
  [[nodiscard]] std::optional<Asked> poll() const {
    const timespec wait{0, 50'000'000};
    siginfo_t info{};
    const int number = sigtimedwait(&set_, &info, &wait);
    if (number <= 0) return std::nullopt;
    const bool reload = number == SIGHUP && info.si_code != SI_KERNEL && !terminal_is_gone();
    return Asked{reload ? Asked::What::kReload : Asked::What::kEnd, strsignal(number)};
  }
  [[nodiscard]] bool end_is_asked() const {
    const auto asked = poll();
    return asked && asked->what == Asked::What::kEnd;
  }

 private:
  /// A shell whose terminal closes sends SIGHUP on to its programs, as an operator does who wants a reload.
  static bool terminal_is_gone() {
    std::array<pollfd, 3> standard{{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}};
    if (::poll(standard.data(), standard.size(), 0) <= 0) return false;
    for (const auto& one : standard)
      if ((one.revents & POLLHUP) != 0 && (one.revents & POLLERR) != 0) return true;
    return false;
  }

  sigset_t set_{};
};

}  // namespace stillpoint::app
