/// `stillpoint convert`: parameters of sensors, simulated or calibrated, between programs, with a list of what is lost
/// on the way.
#include <fmt/format.h>

#include "apps/stillpoint/commands.h"
#include "apps/stillpoint/options.h"
#include "apps/stillpoint/outcome.h"
#include "exchange/parameters.h"
#include "io/text_file.h"

namespace stillpoint::app {
namespace {

struct ConvertArguments {
  std::string input, output, from, to;
};

constexpr auto kFormats = "stillpoint, sdf, matlab, kalibr, px4, sensor, imu_calib";

std::string wrong_format(const std::string& word) {
  return exchange::parameter_format(word) ? "" : fmt::format("{}: no format; known are {}", word, kFormats);
}

int convert(const ConvertArguments& a) {
  const auto text = io::read_text_file(a.input, "parameters of a sensor");
  if (!text) return report(text.error());
  const auto from = a.from.empty() ? exchange::guess_format(a.input, *text) : exchange::parameter_format(a.from);
  if (!from)
    return report(
        {ErrorKind::kBadData, fmt::format("{}: its format is not seen; say --from, one of {}", a.input, kFormats)});
  auto read = exchange::read_parameters(*from, *text, a.input);
  if (!read) return report(read.error());
  const exchange::WrittenParameters written =
      exchange::write_parameters(*exchange::parameter_format(a.to), read->simulation);
  for (const auto& what : read->lost) tell("lost: " + what);
  for (const auto& what : written.lost) tell("lost: " + what);
  if (written.text.empty())
    return report({ErrorKind::kBadData, fmt::format("{}: {} can hold nothing of it", a.input, a.to)});
  if (const auto done = io::write_text_file(a.output, written.text); !done) return report(done.error());
  return 0;
}

}  // namespace

void add_convert(CLI::App& app, Run& run) {
  auto* command = app.add_subcommand(
      "convert",
      "Parameters of a sensor, simulated or calibrated, for Gazebo, MATLAB, Kalibr, PX4, imu_calib, and back");
  static ConvertArguments a;
  command
      ->add_option("input", a.input,
                   "simulation (.yaml), what calibrate --output wrote, SDF, imuSensor JSON, imu.yaml, PX4 parameters, "
                   "imu_calib's YAML")
      ->required()
      ->type_name(kFileType);
  command->add_option("--from", a.from, "its format, where it is not seen: " + std::string(kFormats))
      ->check(wrong_format);
  command->add_option("--to", a.to, "format to write: " + std::string(kFormats))->required()->check(wrong_format);
  add_file(*command, "--output", a.output, "file to write; - is standard output")->required();
  command->callback([&run] { run = [] { return convert(a); }; });
}

}  // namespace stillpoint::app
