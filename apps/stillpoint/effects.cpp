/// `stillpoint effects`: the catalogue of effects, with equations, parameters and units.
#include <CLI/CLI.hpp>
#include <cstdio>

#include "apps/stillpoint/commands.h"
#include "simulation/effect_catalogue.h"

namespace stillpoint::app {

void add_effects(CLI::App& app, Run& run) {
  auto* command =
      app.add_subcommand("effects", "Print every effect a simulation can switch on and a diagnosis can name");
  command->callback([&run] {
    run = [] {
      std::fputs(sim::effect_catalogue_page().c_str(), stdout);
      return 0;
    };
  });
}

}  // namespace stillpoint::app
