/// A program started beside this one; it is asked to end, then made to, when the object goes.
#pragma once
#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "core/result.h"

namespace stillpoint::app {

class ChildProcess {
 public:
  /// Its two outputs go to `log`. Fails (69) when the program cannot be started.
  [[nodiscard]] static Result<ChildProcess> start(const std::vector<std::string>& command, const std::string& log) {
    std::vector<char*> argv;
    argv.reserve(command.size() + 1);
    for (const auto& word : command) argv.push_back(const_cast<char*>(word.c_str()));
    argv.push_back(nullptr);
    const pid_t pid = fork();
    if (pid < 0) return fail(ErrorKind::kUnavailable, command[0] + ": cannot be started: fork failed");
    if (pid == 0) {
      const int file = open(log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
      if (file >= 0) {
        dup2(file, STDOUT_FILENO);
        dup2(file, STDERR_FILENO);
      }
      execv(argv[0], argv.data());
      _exit(kCannotExecute);
    }
    return ChildProcess(pid);
  }
  ChildProcess(ChildProcess&& other) noexcept : pid_(std::exchange(other.pid_, -1)), code_(other.code_) {}
  ChildProcess& operator=(ChildProcess&&) = delete;
  ~ChildProcess() { stop(); }

  /// Its exit code once it has ended (128 + signal when a signal ended it), nothing while it runs.
  std::optional<int> ended() {
    int status = 0;
    if (pid_ > 0 && waitpid(pid_, &status, WNOHANG) == pid_) {
      code_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
      pid_ = -1;
    }
    return code_;
  }

  /// Its exit code, when it has ended.
  int wait() {
    while (!ended()) std::this_thread::sleep_for(std::chrono::milliseconds(10));
    return *code_;
  }

  /// SIGTERM, and SIGKILL when it does not end within two seconds.
  void stop() {
    if (pid_ <= 0) return;
    kill(pid_, SIGTERM);
    for (int i = 0; i < 100 && !ended(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(20));
    if (pid_ > 0) {
      kill(pid_, SIGKILL);
      waitpid(pid_, nullptr, 0);
      pid_ = -1;
    }
  }

 private:
  static constexpr int kCannotExecute = 127;
  explicit ChildProcess(pid_t pid) : pid_(pid) {}
  pid_t pid_;
  std::optional<int> code_;
};

}  // namespace stillpoint::app
