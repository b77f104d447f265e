/// `stillpoint calibrate`: one method on a table of static readings, or the online calibration over a recording.
#include "apps/stillpoint/calibrate.h"

#include "apps/stillpoint/commands.h"

namespace stillpoint::app {
namespace {

struct Arguments {
  std::string points, method, recording, state;
  JsonOption json;
  std::vector<double> initial_centre;
  double initial_radius = 0.0, full_scale_g = 0.0;
  int converter_bits = 0;
  calib::PointsOptions options;
};

int run_calibrate(Arguments a) {
  if (a.points.empty() == a.recording.empty())
    return report({ErrorKind::kUsage, "calibrate needs --points FILE --method METHOD, or --recording FILE"});
  if (!a.recording.empty()) return calibrate_recording(a.recording, a.json.file(), a.state);
  if (!a.initial_centre.empty())
    a.options.initial_centre = Vec3(a.initial_centre[0], a.initial_centre[1], a.initial_centre[2]);
  if (a.initial_radius > 0.0) a.options.initial_radius = a.initial_radius;
  if (a.converter_bits > 0) a.options.converter_bits = a.converter_bits;
  if (a.full_scale_g > 0.0) a.options.full_scale_g = a.full_scale_g;
  return calibrate_points(a.points, a.method, a.options, a.json.file());
}

}  // namespace

void add_calibrate(CLI::App& app, Run& run) {
  auto* command = app.add_subcommand("calibrate", "Calibrate from a table of static readings or from a recording");
  static Arguments a;
  std::string names;
  for (const auto& m : calib::methods()) names += (names.empty() ? "" : ", ") + std::string(m.name);
  auto* points = add_file(*command, "--points", a.points,
                          "CSV with columns x,y,z and optionally var, temp_degC; one static reading a line");
  auto* recording = add_file(*command, "--recording", a.recording,
                             "recording (.csv): detect rest and run the online calibration over it");
  points->excludes(recording);
  a.json.add(*command, "write the result");
  add_file(*command, "--state", a.state, "with --recording: what was learnt; read if it is there, written at the end")
      ->needs(recording);
  command->add_option("--method", a.method, "with --points: " + names)->needs(points);
  const auto of_points = [&](const char* name, auto& value, const char* help) {
    return command->add_option(name, value, help)->needs(points);
  };
  constexpr double kLargest = 1e60;  // as of a reading
  of_points("--initial-centre", a.initial_centre, "with --points: centre x y z that is known beforehand")
      ->expected(3)
      ->check(between(-kLargest, kLargest));
  of_points("--initial-radius", a.initial_radius, "with --points: radius that is known beforehand")
      ->check(between(1.0 / kLargest, kLargest));
  of_points("--prior-sd", a.options.prior_relative_sd, "with --method map: sd of the initial sphere, relative")
      ->check(between(1e-6, 10.0));
  of_points("--converter-bits", a.converter_bits, "with --points: readings lie in [0, 2^bits); checks the radius")
      ->check(CLI::Range(1, 64));
  of_points("--full-scale-g", a.full_scale_g, "with --points: full scale of the sensor; checks the radius")
      ->check(between(0.01, 1e6));
  command->callback([&run] { run = [] { return run_calibrate(a); }; });
}

}  // namespace stillpoint::app
