/// The command line of every program here.
#pragma once
#include <CLI/CLI.hpp>
#include <optional>

namespace stillpoint::bench {

/// Reads it. A value is the exit code that the program ends with at once: 0 after --help, 64 on wrong usage.
[[nodiscard]] inline std::optional<int> parse(CLI::App& app, int argc, char** argv) {
  try {
    app.parse(argc, argv);
    return std::nullopt;
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : 64;
  }
}

}  // namespace stillpoint::bench
