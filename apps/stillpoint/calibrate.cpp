/// `stillpoint calibrate`: one method on a table of static readings, the online calibration over a recording, or how
/// the sensor sits on the body.
#include "apps/stillpoint/calibrate.h"

#include "apps/stillpoint/commands.h"
#include "apps/stillpoint/known_turns.h"
#include "apps/stillpoint/options.h"
#include "apps/stillpoint/outcome.h"

namespace stillpoint::app {
namespace {

struct CalibrateArguments {
  std::string points, method, recording;
  RecordingOptions of_recording;
  MountOptions of_mount;
  JsonOption json;
  std::vector<double> initial_centre;
  double initial_radius = 0.0, full_scale_g = 0.0;
  int converter_bits = 0;
  calib::PointsOptions options;
};

int run_calibrate(CalibrateArguments a) {
  const bool mount = !a.of_mount.recordings.empty();
  if (!a.points.empty() + !a.recording.empty() + mount != 1)
    return report(
        {ErrorKind::kUsage, "calibrate needs --points FILE --method METHOD, or --recording FILE, or --mount FILE..."});
  const RecordingOptions& r = a.of_recording;
  if (!a.points.empty() && (!r.output.empty() || r.latitude_deg))
    return report({ErrorKind::kUsage, "calibrate: --output and --latitude need --recording or --mount"});
  if (mount) {
    a.of_mount.output = r.output;
    a.of_mount.latitude_deg = r.latitude_deg;
    return calibrate_mount(a.of_mount, a.json.file());
  }
  if (!a.recording.empty()) return calibrate_recording(a.recording, a.json.file(), a.of_recording);
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
  static CalibrateArguments a;
  std::string names;
  for (const auto& m : calib::methods()) names += (names.empty() ? "" : ", ") + std::string(m.name);
  auto* points = add_file(*command, "--points", a.points,
                          "CSV with columns x,y,z and optionally var, temp_degC; one static reading a line");
  auto* recording = add_file(*command, "--recording", a.recording,
                             "recording (.csv): detect rest and run the online calibration over it");
  points->excludes(recording);
  auto* mount = command->add_option("--mount", a.of_mount.recordings,
                                    "recordings (.csv) of rests in stated poses and the turns between them: first the "
                                    "body as it stands, level, then tipped so that its front is up (body x), then on "
                                    "its other sides as you like, 3 s each; tells how each sensor sits on the body");
  mount->type_name(kFileType)->excludes(points)->excludes(recording);
  command
      ->add_option("--faces", a.of_mount.faces,
                   "with --mount: the body's axes that are up, rest by rest, such as +z,+x,-y; x forward, y left")
      ->check(CLI::IsMember({"+x", "-x", "+y", "-y", "+z", "-z"}))
      ->delimiter(',')
      ->needs(mount)
      ->capture_default_str();
  command->add_option("--pose-sd", a.of_mount.pose_sd_deg, "with --mount: how well each pose is kept, deg (sd)")
      ->check(between(0.01, 10.0))
      ->needs(mount)
      ->capture_default_str();
  a.json.add(*command, "write the result");
  RecordingOptions& r = a.of_recording;
  add_file(*command, "--config", r.config, "with --recording: the daemon's configuration; its sensor and priors serve")
      ->needs(recording);
  add_file(*command, "--output", r.output,
           "what was found, YAML for the daemon: with --recording a 'sensor:', with --mount the mounts");
  add_file(*command, "--report", r.report, "with --recording: the calibration as a page (.html)")->needs(recording);
  command->add_option("--sensor-id", r.sensor_id, "with --recording: the sensor, whatever the recording calls it")
      ->needs(recording);
  auto* gravity = command->add_option("--gravity", r.gravity_mps2, "with --recording: where it was made, m/s^2");
  gravity->needs(recording)->check(between(9.7, 9.9));
  command
      ->add_option(
          "--latitude", r.latitude_deg,
          "with --recording: the same by the latitude, deg, at sea level; with --mount: the side of the equator")
      ->excludes(gravity)
      ->check(between(-90.0, 90.0));
  const auto known = [&](const char* name, std::vector<std::string>& texts, const char* type, const char* help,
                         const auto& parse) {
    const auto refusal = [&parse](const std::string& text) {
      const auto parsed = parse(text);
      return parsed ? std::string() : parsed.error().message;
    };
    command->add_option(name, texts, help)
        ->type_name(type)
        ->allow_extra_args(false)
        ->check(CLI::Validator(refusal, ""))
        ->needs(recording);
  };
  known("--turn", r.turns, kTurnType,
        "with --recording, again and again: from rest to rest, seconds since its first row, the body was turned about "
        "one axis by so many degrees, such as 66:70.5:360; sd 1.5 deg unless given",
        parse_turn);
  known("--rate", r.rates, kRateType,
        "the same for a turntable: all the time it turned at this rate, such as 20:80:200 or 20:80:33.333rpm; sd 0.3 % "
        "unless given",
        parse_rate);
  add_file(*command, "--state", r.state, "with --recording: what was learnt; read if it is there, written at the end")
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
