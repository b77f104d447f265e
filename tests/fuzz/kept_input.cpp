#include "tests/fuzz/kept_input.h"

#include <fcntl.h>
#include <signal.h>
#include <unistd.h>

#include <array>
#include <cstring>
#include <string_view>

#include "core/fnv1a.h"

/// There where a sanitizer is linked.
extern "C" void __sanitizer_set_death_callback(void (*callback)()) __attribute__((weak));

namespace stillpoint::fuzz {
namespace {

// What a signal handler may touch: plain memory, and open() and write().
std::array<char, 4096> path{};
std::size_t prefix_size = 0;
std::span<const std::uint8_t> running;
bool is_running = false;
unsigned timeout_s = 0;

void say(std::string_view what) noexcept {
  if (write(STDERR_FILENO, what.data(), what.size()) < 0) return;  // nobody listens
}

void append(std::size_t& end, std::string_view what) noexcept {
  std::memcpy(path.data() + end, what.data(), what.size());
  end += what.size();
}

void keep(std::string_view kind) noexcept {
  if (!is_running) return;
  is_running = false;  // once: a sanitizer's death is followed by a signal
  const std::uint64_t hash = fnv1a({reinterpret_cast<const char*>(running.data()), running.size()});
  std::size_t end = prefix_size;
  append(end, kind);
  for (unsigned shift = 64; shift > 0; shift -= 4) append(end, {&"0123456789abcdef"[hash >> (shift - 4) & 15U], 1});
  path[end] = '\0';
  const int fd = open(path.data(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
  const bool written = fd >= 0 && write(fd, running.data(), running.size()) == static_cast<ssize_t>(running.size());
  say(written ? "Test unit written to " : "Test unit CANNOT be written to ");
  say({path.data(), end});
  say("\n");
}

void on_death() { keep("crash-"); }

void on_signal(int number) {
  keep(number == SIGALRM ? "timeout-" : "crash-");
  signal(number, SIG_DFL);
  raise(number);
}

}  // namespace

void keep_fatal_inputs(const std::string& prefix, unsigned timeout) {
  prefix_size = prefix.copy(path.data(), path.size() / 2);
  timeout_s = timeout;
  const bool sanitized = __sanitizer_set_death_callback != nullptr;
  if (sanitized) __sanitizer_set_death_callback(on_death);
  static std::array<char, 1 << 16> stack;  // of its own: an endless recursion leaves none
  const stack_t other{.ss_sp = stack.data(), .ss_flags = 0, .ss_size = stack.size()};
  sigaltstack(&other, nullptr);
  struct sigaction action {};
  action.sa_handler = on_signal;
  action.sa_flags = SA_ONSTACK;
  for (const int number : {SIGABRT, SIGALRM}) sigaction(number, &action, nullptr);
  if (!sanitized)  // which says more of these itself
    for (const int number : {SIGSEGV, SIGBUS, SIGFPE, SIGILL}) sigaction(number, &action, nullptr);
}

void now_running(std::span<const std::uint8_t> input) noexcept {
  running = input;
  is_running = true;
  alarm(timeout_s);
}

void nothing_running() noexcept {
  is_running = false;
  alarm(0);
}

}  // namespace stillpoint::fuzz
