/// A bar on standard error for what takes long enough to wonder: on a terminal only, and only after a second.
#pragma once
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <mutex>
#include <string>

namespace stillpoint::app {

class Progress {
 public:
  explicit Progress(std::string what) : what_(std::move(what)), terminal_(isatty(STDERR_FILENO) != 0) {}
  ~Progress() {
    if (drawn_) fmt::print(stderr, "\r{:78}\r", "");
  }
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// `share` of the work that is done, 0 to 1. From any thread.
  void at(double share) {
    if (!terminal_) return;
    constexpr double kWidth = 40.0, kSilent_s = 1.0, kRedraw_s = 0.1;
    const std::lock_guard lock(drawing_);
    const double spent_s = seconds();
    if (spent_s < kSilent_s || spent_s < last_s_ + kRedraw_s) return;
    last_s_ = spent_s;
    drawn_ = true;
    share = std::clamp(share, 0.0, 1.0);
    const auto full = static_cast<std::size_t>(kWidth * share);
    const std::string left =
        share > 0.05 ? fmt::format(", {:.0f} s left", spent_s * (1.0 - share) / share) : std::string();
    fmt::print(stderr, "\r{} [{:.<40}] {:3.0f} %{:14}", what_, std::string(full, '#'), 100.0 * share, left);
    std::fflush(stderr);
  }

 private:
  [[nodiscard]] double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }

  std::string what_;
  bool terminal_, drawn_ = false;
  double last_s_ = 0.0;
  std::mutex drawing_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace stillpoint::app
