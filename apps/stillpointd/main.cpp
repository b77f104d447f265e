/// `stillpointd`: the daemon. docs/daemon.md says how to run it, docs/configuration.md what it can be told.
#include <CLI/CLI.hpp>

#include "apps/stillpointd/daemon.h"
#include "apps/stillpointd/log.h"
#include "io/text_file.h"

int main(int argc, char** argv) {
  using namespace stillpoint;
  CLI::App cli{"Attitude from an inertial and magnetic sensor that calibrates itself while it lies still.",
               "stillpointd"};
  cli.set_version_flag("--version", "stillpointd " STILLPOINT_VERSION);
  std::string path;
  bool check = false, print = false;
  app::DaemonOptions options;
  cli.add_option("--config", path, "configuration (.yaml)")->required();
  cli.add_flag("--check-config", check, "say what is wrong with the configuration, and end (78 on any fault)");
  cli.add_flag("--print-config", print, "show every value, its meaning and whether it is the default, and end");
  cli.add_option("--wait-for-subscribers", options.wait_for_subscribers,
                 "hold the first sample back until so many subscribers of the attitude are there")
      ->check(CLI::Range(0, 1000));
  try {
    cli.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return cli.exit(e) == 0 ? 0 : static_cast<int>(ErrorKind::kUsage);
  }
  const auto refused = [](const Error& error) {
    app::log(error.message);
    return static_cast<int>(error.kind);
  };
  const auto config = io::read_config(path);
  if (!config) return refused(config.error());
  if (!print && !check) {
    if (config->source.kind == io::SourceKind::kNone)
      return refused({ErrorKind::kBadConfig, path + ": no 'source:'; name a recording or a simulation there"});
    return app::run_daemon(*config, options);
  }
  const auto said = io::write_text_file(
      "-", (print ? io::print_config(*config) : "") + (check ? path + ": a configuration without fault\n" : ""));
  return said ? 0 : refused(said.error());
}
