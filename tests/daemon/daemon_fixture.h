/// A daemon with a scratch folder of its own, for what the world may do to it.
#pragma once
#include <chrono>
#include <memory>
#include <thread>

#include "tests/apps/apps_testing.h"

namespace stillpoint::test {

namespace fs = std::filesystem;

class DaemonFaults : public testing::Test {
 protected:
  void configure(const std::string& extra = {}, const std::string& speed = "50") {
    write_file(scratch_ / "d.yaml", "source: {kind: simulation, file: " + configs("sim_handheld.yaml") + ", speed: " +
                                        speed + "}\nsensor: {id: test}\nstate: {directory: " + (scratch_ / "state") +
                                        ", save_period_s: 0.1}\ndds: {domain: " + std::to_string(io::own_domain()) +
                                        ", ros2: false, raw_topic: \"\"}\n" + extra);
  }
  /// `before` stands before the program in the shell's line.
  std::unique_ptr<Process> start(const std::string& before = {}, const std::string& log = "log") {
    return std::make_unique<Process>(std::vector<std::string>{
        "/bin/sh", "-c",
        before + " exec " + wrapper_ + " " STILLPOINTD " --config " + (scratch_ / "d.yaml") + " 2>" + log_file(log)});
  }
  [[nodiscard]] std::string log_file(const std::string& log) const { return log[0] == '/' ? log : scratch_ / log; }
  [[nodiscard]] std::string log(const std::string& name = "log") const { return read_file(scratch_ / name); }
  [[nodiscard]] bool says(const std::string& text, const std::string& name = "log") const {
    return within_20_s([&] { return log(name).find(text) != std::string::npos; });
  }
  template <class Condition>
  static bool within_20_s(const Condition& condition) {
    for (int i = 0; i < 400; ++i) {
      if (condition()) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    return condition();
  }
  [[nodiscard]] bool keeps_a_state() const {
    return within_20_s([this] { return fs::exists(scratch_ / "state/test.state"); });
  }
  static int end(Process& daemon) {
    daemon.send(SIGTERM);
    return daemon.wait();
  }

  ScratchFolder scratch_;
  std::string wrapper_;
};

}  // namespace stillpoint::test
