/// Prints every calibration figure of docs/calibration_figures.md: paper beside ours. `--help` names the parts.
#include <functional>

#include "bench/arguments.h"
#include "bench/calibration_tables.h"
#include "tests/source_folder.h"

int main(int argc, char** argv) {
  using namespace stillpoint::bench;
  unsigned first_seed = 0, seeds = 40;
  std::string recordings = stillpoint::in_source("../shared/recordings");
  const std::vector<std::pair<std::string, std::function<void()>>> parts{
      {"gietzelt", gietzelt_tables},
      {"zhang", zhang_tables},
      {"worn", worn_and_adjusted},
      {"day", simulated_day},
      {"alignment", alignment_and_gyro},
      {"rest", rest_detection},
      {"ordinary", [&] { ordinary_use(first_seed, seeds); }},
      {"recordings", [&] { real_recordings(recordings); }}};
  std::vector<std::string> names, wanted;
  for (const auto& [name, print] : parts) names.push_back(name);
  CLI::App app{"Every calibration figure of docs/calibration_figures.md, paper beside ours"};
  app.add_option("PART", wanted, "which to print; all unless given")->check(CLI::IsMember(names));
  app.add_option("--recordings", recordings, "folder of the real recordings")->capture_default_str();
  app.add_option("--first-seed", first_seed, "of the ordinary use")->capture_default_str();
  app.add_option("--seeds", seeds, "of the ordinary use")->capture_default_str();
  if (const auto end = parse(app, argc, argv)) return *end;
  for (const auto& [name, print] : parts)
    if (wanted.empty() || std::find(wanted.begin(), wanted.end(), name) != wanted.end()) print();
  return 0;
}
