/// The subcommands of `stillpoint`. Each lives in its own file, adds itself to the command line and sets `run` when
/// chosen.
#pragma once
#include <functional>

namespace CLI {
class App;
}

namespace stillpoint::app {

/// Exit code of the chosen command; empty until one is chosen.
using Run = std::function<int()>;

void add_calibrate(CLI::App& app, Run& run);
void add_check(CLI::App& app, Run& run);
void add_convert(CLI::App& app, Run& run);
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
