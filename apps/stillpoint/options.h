/// Options that several commands have.
#pragma once
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <string>

namespace stillpoint::app {

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

}  // namespace stillpoint::app
