/// `stillpoint`: the command line tool. `stillpoint --help` lists the commands.
#include "apps/stillpoint/commands.h"

int main(int argc, char** argv) {
  using namespace stillpoint;
  CLI::App cli{"Self-calibrating attitude, and the physics a simulation left out."};
  cli.require_subcommand(1);
  app::Run run;
  app::add_calibrate(cli, run);
  app::add_check(cli, run);
  app::add_demo(cli, run);
  app::add_diagnose(cli, run);
  app::add_estimate(cli, run);
  app::add_noise(cli, run);
  app::add_prove(cli, run);
  app::add_record(cli, run);
  app::add_effects(cli, run);
  app::add_simulate(cli, run);
  app::add_watch(cli, run);
  try {
    cli.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return cli.exit(e) == 0 ? 0 : static_cast<int>(ErrorKind::kUsage);
  }
  return run();
}
