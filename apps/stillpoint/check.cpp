/// `stillpoint check FILE`: says what is wrong with a recording, a configuration or a simulation.
#include "apps/stillpoint/commands.h"
#include "io/recording.h"

namespace stillpoint::app {
namespace {

int check_recording(const std::string& path) {
  const auto recording = io::read_recording(path);
  if (!recording) return report(recording.error());
  std::printf("%s: %zu rows, %.1f s\n", path.c_str(), recording->size(),
              recording->t_s(recording->size() - 1) - recording->t_s(0));
  for (const auto& line : io::describe(recording->issues)) std::printf("%s: %s\n", path.c_str(), line.c_str());
  return 0;
}

}  // namespace

void add_check(CLI::App& app, Run& run) {
  auto* command = app.add_subcommand("check", "Say what is wrong with a recording, a configuration or a simulation");
  static std::string path;
  command->add_option("FILE", path, "recording (.csv), configuration or simulation (.yaml)")->required();
  command->callback([&run] { run = [] { return check_recording(path); }; });
}

}  // namespace stillpoint::app
