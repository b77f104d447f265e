/// The subcommands of `stillpoint`. Each lives in its own file, adds itself to the command line and sets `run` when
/// chosen.
#pragma once
#include <CLI/CLI.hpp>
#include <cstdio>
#include <functional>

#include "core/result.h"

namespace stillpoint::app {

/// Exit code of the chosen command; empty until one is chosen.
using Run = std::function<int()>;

/// Prints the error to standard error and gives its exit code.
inline int report(const Error& error) {
  std::fprintf(stderr, "stillpoint: %s\n", error.message.c_str());
  return static_cast<int>(error.kind);
}

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
