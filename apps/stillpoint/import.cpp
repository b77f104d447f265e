/// `stillpoint import`: recordings of phones, flight controllers, data sets and ROS 2 bags as recordings of ours.
#include "exchange/import.h"

#include <fmt/format.h>

#include "apps/stillpoint/commands.h"
#include "apps/stillpoint/options.h"
#include "apps/stillpoint/outcome.h"
#include "core/nearest.h"
#include "io/text_file.h"

namespace stillpoint::app {
namespace {

struct ImportArguments {
  std::string input, output, preset, map, topic;
};

std::string preset_list() {
  std::string text;
  for (const auto& p : exchange::presets()) text += fmt::format("  {:14} {}\n", p.name, p.about);
  return text;
}

/// Empty, or what is wrong with the name of a preset.
std::string wrong_preset(const std::string& wanted) {
  std::vector<std::string_view> names;
  for (const auto& p : exchange::presets()) names.push_back(p.name);
  if (std::find(names.begin(), names.end(), wanted) != names.end()) return "";
  const auto meant = nearest(wanted, names);
  return meant.empty() ? fmt::format("{}: no preset; known are {}", wanted, fmt::join(names, ", "))
                       : fmt::format("{}: no preset; did you mean {}?", wanted, meant);
}

int import(const ImportArguments& a) {
  exchange::ImportOptions options{a.preset, std::nullopt, a.topic};
  if (!a.preset.empty() && !a.map.empty())
    return report({ErrorKind::kUsage, "--preset and --map exclude each other; a map says it all"});
  if (!a.map.empty()) {
    auto map = exchange::read_column_map(a.map);
    if (!map) return report(map.error());
    options.map = std::move(*map);
  }
  if (const auto writable = io::expect_writable(a.output); !writable) return report(writable.error());
  auto imported = exchange::import_recording(a.input, options);
  if (!imported) return report(imported.error());
  imported->recording.header["source"] = "stillpoint import of " + a.input;
  imported->recording.header["world_frame"] = "ENU";
  if (const auto written = io::write_recording(imported->recording, a.output); !written) return report(written.error());
  for (const auto& reason : imported->reasons) tell(reason);
  tell(fmt::format("{}: {} rows, {:.1f} s", a.output, imported->recording.size(),
                   imported->recording.t_s(imported->recording.size() - 1)));
  return 0;
}

}  // namespace

void add_import(CLI::App& app, Run& run) {
  auto* command =
      app.add_subcommand("import", "Read the recording of another program: phone, PX4, EuRoC, ROS 2 bag, any CSV");
  static ImportArguments a;
  command->add_option("input", a.input, "file (.csv, .zip, .gz, .ulg, .mcap) or folder")
      ->required()
      ->type_name(kFileType);
  add_file(*command, "--output", a.output, "recording to write (.csv); - is standard output")->required();
  command->add_option("--preset", a.preset, "the program that wrote it, where it is not found out")
      ->check(wrong_preset);
  add_file(*command, "--map", a.map, "which columns are what, in which unit (.yaml; docs/import.md)");
  command->add_option("--topic", a.topic, "of a ROS 2 bag: this topic instead of the one with most messages");
  command->footer("Presets:\n" + preset_list());
  command->callback([&run] { run = [] { return import(a); }; });
}

}  // namespace stillpoint::app
