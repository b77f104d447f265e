/// `stillpoint demo` as a program of its own, which is built in a third of the tool's time.
#include <CLI/CLI.hpp>

#include "apps/stillpoint/commands.h"

int main(int argc, char** argv) {
  CLI::App cli{"The demo of stillpoint.", "stillpoint_demo"};
  cli.require_subcommand(1);
  stillpoint::app::Run run;
  stillpoint::app::add_demo(cli, run);
  CLI11_PARSE(cli, argc, argv);
  return run();
}
