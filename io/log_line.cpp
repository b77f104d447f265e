#include "io/log_line.h"

#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <system_error>
#include <thread>
#include <utility>

namespace stillpoint::io {
namespace {

constexpr std::size_t kMostLines = 1000;

/// As much as standard error takes; what it refuses for good is lost.
void write_all(const std::string& text) {
  std::size_t done = 0;
  while (done < text.size()) {
    const ssize_t n = ::write(STDERR_FILENO, text.data() + done, text.size() - done);
    if (n > 0) done += static_cast<std::size_t>(n);
    if (n < 0 && errno == EAGAIN) std::this_thread::sleep_for(std::chrono::milliseconds(20));
    if (n < 0 && errno != EINTR && errno != EAGAIN) return;
  }
}

class Queue {
 public:
  void put(std::string line) {
    const std::lock_guard lock(mutex_);
    if (!has_thread_ && !start()) return write_all(line + '\n');
    if (lines_.size() >= kMostLines) {
      ++lost_;
      return;
    }
    lines_.push_back(std::move(line) + '\n');
    more_.notify_one();
  }

  bool flush(double timeout_s) {
    std::unique_lock lock(mutex_);
    return written_.wait_for(lock, std::chrono::duration<double>(timeout_s),
                             [this] { return lines_.empty() && !writing_; });
  }

 private:
  /// Never joined: it may be held in a write for ever, and the program ends all the same.
  bool start() {
    try {
      std::thread([this] { run(); }).detach();
      return has_thread_ = true;
    } catch (const std::system_error&) {  // no more threads: this line is why, and it is written here
      return false;
    }
  }

  void run() {
    std::unique_lock lock(mutex_);
    while (true) {
      more_.wait(lock, [this] { return !lines_.empty(); });
      std::string text = std::move(lines_.front());
      lines_.pop_front();
      if (lost_ > 0 && lines_.empty())
        text += std::to_string(std::exchange(lost_, 0)) + " lines lost: not read in time\n";
      writing_ = true;
      lock.unlock();
      write_all(text);
      lock.lock();
      writing_ = false;
      written_.notify_all();
    }
  }

  std::mutex mutex_;
  std::condition_variable more_, written_;
  std::deque<std::string> lines_;
  std::size_t lost_ = 0;
  bool writing_ = false, has_thread_ = false;
};

/// Never destroyed: its thread outlives main.
Queue& queue() {
  static Queue& one = *new Queue;
  return one;
}

}  // namespace

void log_line(std::string line) { queue().put(std::move(line)); }
bool flush_log(double timeout_s) { return queue().flush(timeout_s); }

}  // namespace stillpoint::io
