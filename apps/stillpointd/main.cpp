/// `stillpointd`: the daemon. docs/daemon.md says how to run it, docs/configuration.md what it can be told.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <string_view>

#include "apps/stillpointd/daemon.h"
#include "apps/stillpointd/log.h"
#include "apps/stillpointd/outlet.h"
#include "io/log_line.h"
#include "io/text_file.h"
#include "sources/check_source.h"

namespace {

using namespace stillpoint;

int refused(const Error& error) {
  app::log(error.message);
  return static_cast<int>(error.kind);
}

int run(int argc, char** argv) {
  CLI::App cli{"Attitude from an inertial and magnetic sensor that calibrates itself while it lies still.",
               "stillpointd"};
  cli.set_version_flag("--version", "stillpointd " STILLPOINT_VERSION);
  bool check = false, print = false;
  app::DaemonOptions options;
  std::string& path = options.config_file;
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
  const auto config = io::read_config(path);
  if (!config) return refused(config.error());
  if (!print && !check) {
    if (config->source.kind == io::SourceKind::kNone)
      return refused({ErrorKind::kBadConfig,
                      path + ": no 'source:'; name one there, such as source: {kind: stream, from: stdin}"});
    return app::run_daemon(*config, options);
  }
  if (check) {
    for (const auto& line : io::warnings(config->dds.security)) app::log(path + ": " + line);
    if (const auto there = sources::check_source(config->source); !there) return refused(there.error());
  }
  const auto said = io::write_text_file(
      "-", (print ? io::print_config(*config) : "") + (check ? path + ": a configuration without fault\n" : ""));
  return said ? 0 : refused(said.error());
}

/// `--wire A,B`: what the daemon itself starts, with two sockets (dds.own_process).
bool is_wire(int argc, char** argv, int& attitudes, int& others) {
  return argc == 3 && std::string_view(argv[1]) == "--wire" &&
         std::sscanf(argv[2], "%d,%d", &attitudes, &others) == 2;  // NOLINT(cert-err34-c): written by this program
}

}  // namespace

int main(int argc, char** argv) {
  constexpr double kLastLines_s = 0.5;
  int code = 0;
  try {
    int attitudes = -1, others = -1;
    code = is_wire(argc, argv, attitudes, others) ? app::serve_as_wire(attitudes, others) : run(argc, argv);
  } catch (const std::exception& e) {  // threads, memory or files beyond the limits of the process
    code =
        refused({ErrorKind::kUnavailable,
                 std::string("the machine refuses what the daemon needs: ") + e.what() +
                     "; raise the limit of threads (ulimit -u, TasksMax=), files (ulimit -n, LimitNOFILE=) or memory "
                     "(ulimit -v, MemoryMax=)"});
  }
  io::flush_log(kLastLines_s);
  return code;
}
