/// `stillpoint calibrate --mount`: how the sensors sit on the body, from rests in stated poses.
#include <fmt/format.h>

#include "apps/stillpoint/calibrate.h"
#include "apps/stillpoint/calibrate_mount_report.h"
#include "apps/stillpoint/json_text.h"
#include "apps/stillpoint/outcome.h"
#include "apps/stillpoint/plausible.h"
#include "core/units.h"
#include "io/recording.h"
#include "io/text_file.h"

namespace stillpoint::app {
namespace {

Result<std::vector<RawSample>> samples_of(const std::string& path) {
  const auto recording = io::read_recording(path);
  if (!recording) return tl::unexpected(recording.error());
  if (recording->acc_mps2.empty() || recording->acc_in_counts || recording->gyr_in_counts)
    return fail(ErrorKind::kBadData,
                path + ": the mounting needs acc_*_mps2 or acc_*_g, and a gyroscope in rad/s or deg/s, not counts");
  warn_if_implausible(*recording, path);
  for (const auto& line : io::describe(recording->issues)) tell(fmt::format("{}: {}", path, line));
  std::vector<RawSample> samples(recording->size());
  for (std::size_t row = 0; row < samples.size(); ++row) {
    samples[row] = recording->sample(row);
    if (recording->mag_in_counts) samples[row].has &= static_cast<std::uint8_t>(~kMag);
  }
  return samples;
}

/// Pre: "+x" to "-z".
Vec3 axis_named(const std::string& name) { return (name[0] == '-' ? -1.0 : 1.0) * Vec3::Unit(name[1] - 'x'); }

}  // namespace

int calibrate_mount(const MountOptions& options, const std::string& json) {
  MountRun run;
  run.recordings = options.recordings;
  run.params.pose_sd_rad = options.pose_sd_deg * kRadPerDeg;
  run.params.faces.clear();
  for (const std::string& face : options.faces) run.params.faces.push_back(axis_named(face));
  bool tipped = false;
  for (const Vec3& face : run.params.faces) tipped = tipped || face.cross(run.params.faces.front()).norm() > 0.5;
  if (!tipped)
    return report({ErrorKind::kUsage, "calibrate: --faces needs two that are neither the same nor opposite: +z,+x"});
  if (options.latitude_deg) run.params.north = *options.latitude_deg > 0.0;
  std::vector<std::vector<RawSample>> recordings;
  for (const std::string& path : options.recordings) {
    auto samples = samples_of(path);
    if (!samples) return report(samples.error());
    recordings.push_back(std::move(*samples));
  }
  run.evidence = calib::mount_evidence(recordings);
  run.fit = calib::fit_mount(run.evidence, run.params);
  if (!json.empty()) {
    if (const auto done = io::write_text_file(json, json_text(to_json(run))); !done) return report(done.error());
  }
  if (json != "-") print(run);
  const bool refused = run.mirrored() || !run.fit.acc.known();
  if (refused)
    for (const std::string& line : missing(run)) tell("stillpoint: " + line);
  const std::string yaml = mount_yaml(run);
  if (!options.output.empty() && !yaml.empty())
    if (const auto done = io::write_text_file(options.output, yaml); !done) return report(done.error());
  return refused ? static_cast<int>(ErrorKind::kBadData) : 0;
}

}  // namespace stillpoint::app
