/// The subcommands of `stillpoint`. Each lives in its own file, adds itself to the command line and sets `run` when
/// chosen.
#pragma once
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <functional>
#include <optional>
#include <string>

#include "core/result.h"

namespace stillpoint::app {

/// Exit code of the chosen command; empty until one is chosen.
using Run = std::function<int()>;

/// Prints the error to standard error and gives its exit code.
inline int report(const Error& error) {
  std::fprintf(stderr, "stillpoint: %s\n", error.message.c_str());
  return static_cast<int>(error.kind);
}

/// A finite number from low to high: CLI::Range lets nan pass.
inline CLI::Validator between(double low, double high) {
  const auto refusal = [low, high](const std::string& text) {
    double value = 0.0;
    const bool good = CLI::detail::lexical_cast(text, value) && value >= low && value <= high;
    return good ? std::string() : fmt::format("{} is no number from {:g} to {:g}", text, low, high);
  };
  return {refusal, fmt::format("{:g} - {:g}", low, high)};
}

/// `--json [FILE]`: JSON into a file, or to standard output and nothing else there.
class JsonOption {
 public:
  void add(CLI::App& command, const std::string& what) {
    option_ =
        command
            .add_option("--json", name_, what + " as JSON into this file; without a name or with -: to standard output")
            ->expected(0, 1);
  }
  /// Empty when it was not given; "-" is standard output.
  [[nodiscard]] std::optional<std::string> target() const {
    if (option_ == nullptr || option_->count() == 0) return std::nullopt;
    return name_.empty() ? "-" : name_;
  }

 private:
  std::string name_;
  CLI::Option* option_ = nullptr;
};

void add_calibrate(CLI::App& app, Run& run);
void add_check(CLI::App& app, Run& run);
void add_demo(CLI::App& app, Run& run);
void add_diagnose(CLI::App& app, Run& run);
void add_estimate(CLI::App& app, Run& run);
void add_noise(CLI::App& app, Run& run);
void add_prove(CLI::App& app, Run& run);
void add_record(CLI::App& app, Run& run);
void add_effects(CLI::App& app, Run& run);
void add_simulate(CLI::App& app, Run& run);
void add_watch(CLI::App& app, Run& run);

}  // namespace stillpoint::app
