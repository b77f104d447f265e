/// The subcommands of `stillpoint`. Each lives in its own file, adds itself to the command line and sets `run` when
/// chosen.
#pragma once
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <functional>
#include <string>

#include "core/result.h"
#include "io/quote.h"

namespace stillpoint::app {

/// Exit code of the chosen command; empty until one is chosen.
using Run = std::function<int()>;

/// A line on standard error. Where that is closed or full the line is lost; fmt::print would end the program. Messages
/// name what stands in files, and no file may steer the terminal.
inline void tell(const std::string& line) { std::fputs((io::without_controls(line) + '\n').c_str(), stderr); }

/// Prints the error to standard error and gives its exit code.
inline int report(const Error& error) {
  tell("stillpoint: " + error.message);
  return static_cast<int>(error.kind);
}

/// Whether one of these files is "-", standard output, where then nothing else may be written. Fails (64) when two are.
inline Result<bool> is_standard_output(std::initializer_list<std::string> files) {
  const auto count = std::count(files.begin(), files.end(), "-");
  if (count > 1)
    return fail(ErrorKind::kUsage, "only one output can be '-', standard output; name files for the others");
  return count == 1;
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

constexpr auto kFileType = "FILE";  ///< what an option is called that names a file

/// An option that names a file to read or to write. No two of a command may name the same one (64).
inline CLI::Option* add_file(CLI::App& command, const std::string& option, std::string& file, const std::string& help) {
  return command.add_option(option, file, help)->type_name(kFileType);
}

/// `--json [FILE]`: JSON into a file, or to standard output and nothing else there.
class JsonOption {
 public:
  void add(CLI::App& command, const std::string& what) {
    option_ = add_file(command, "--json", name_,
                       what + " as JSON into this file; without a name or with -: to standard output");
    option_->expected(0, 1);
  }
  /// Empty when it was not given; "-" is standard output.
  [[nodiscard]] std::string file() const {
    if (option_ == nullptr || option_->count() == 0) return "";
    return name_.empty() ? "-" : name_;
  }

 private:
  std::string name_;
  CLI::Option* option_ = nullptr;
};

void add_calibrate(CLI::App& app, Run& run);
void add_check(CLI::App& app, Run& run);
void add_demo(CLI::App& app, Run& run);
void add_devices(CLI::App& app, Run& run);
void add_diagnose(CLI::App& app, Run& run);
void add_estimate(CLI::App& app, Run& run);
void add_import(CLI::App& app, Run& run);
void add_merge(CLI::App& app, Run& run);
void add_noise(CLI::App& app, Run& run);
void add_page(CLI::App& app, Run& run);
void add_prove(CLI::App& app, Run& run);
void add_record(CLI::App& app, Run& run);
void add_effects(CLI::App& app, Run& run);
void add_simulate(CLI::App& app, Run& run);
void add_status(CLI::App& app, Run& run);
void add_watch(CLI::App& app, Run& run);

}  // namespace stillpoint::app
