/// A child process for the tests that need a second one: started, read, stopped, killed; never left behind.
#pragma once
#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <string>
#include <vector>

extern char** environ;

namespace stillpoint::test {

class Process {
 public:
  /// Standard output goes to a pipe that output() reads; standard error to the file named, or where the caller's goes.
  explicit Process(std::vector<std::string> command, const std::string& errors_to = {}) {
    std::array<int, 2> ends{};
    if (pipe(ends.data()) != 0) return;
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
    posix_spawn_file_actions_addclose(&actions, ends[0]);
    if (!errors_to.empty())
      posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, errors_to.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    std::vector<char*> argv;
    for (std::string& word : command) argv.push_back(word.data());
    argv.push_back(nullptr);
    if (posix_spawn(&pid_, argv[0], &actions, nullptr, argv.data(), environ) != 0) pid_ = -1;
    posix_spawn_file_actions_destroy(&actions);
    close(ends[1]);
    from_child_ = ends[0];
  }
  ~Process() {
    if (pid_ > 0) {
      send(SIGKILL);
      wait();
    }
    if (from_child_ >= 0) close(from_child_);
  }
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  [[nodiscard]] bool started() const { return pid_ > 0; }
  [[nodiscard]] pid_t id() const { return pid_; }
  /// Does nothing when there is no child: kill(-1, ...) would reach every process of the user.
  void send(int signal_number) const {
    if (pid_ > 0) kill(pid_, signal_number);
  }
  /// Exit code; 128 + signal when killed, 127 when it never started.
  int wait() {
    if (pid_ <= 0) return 127;
    int status = 0;
    waitpid(pid_, &status, 0);
    pid_ = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }
  /// Everything until the child closes its output.
  std::string output() {
    std::string all;
    std::array<char, 4096> part{};
    for (ssize_t n = 0; (n = read(from_child_, part.data(), part.size())) > 0;)
      all.append(part.data(), static_cast<std::size_t>(n));
    return all;
  }
  /// Blocks until the child writes something.
  std::string some_output() {
    std::array<char, 4096> part{};
    const ssize_t n = read(from_child_, part.data(), part.size());
    return n > 0 ? std::string(part.data(), static_cast<std::size_t>(n)) : std::string();
  }

 private:
  pid_t pid_ = -1;
  int from_child_ = -1;
};

}  // namespace stillpoint::test
