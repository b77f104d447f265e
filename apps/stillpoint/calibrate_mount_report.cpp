#include "apps/stillpoint/calibrate_mount_report.h"

#include <fmt/format.h>

#include <array>
#include <cmath>

#include "apps/stillpoint/calibrate_mount_words.h"
#include "calib_online/offline/axis_maps.h"
#include "core/units.h"
#include "io/mount.h"

namespace stillpoint::app {
namespace {

using Json = nlohmann::ordered_json;
using calib::MountLack;
using calib::SensorMount;

double deg(double rad) { return rad * kDegPerRad; }

/// "+x +y +z" in quotes, or [w, x, y, z] where the remainder says more than the names.
std::string value(const SensorMount& mount) {
  const calib::NamedMount n = calib::named(mount.R, mount.covariance);
  if (!n.significant) return '"' + io::mount_names(n.map) + '"';
  const Quat q(mount.R);
  return fmt::format("[{:.6f}, {:.6f}, {:.6f}, {:.6f}]", q.w(), q.x(), q.y(), q.z());
}

std::string remark(const SensorMount& mount) {
  const calib::NamedMount n = calib::named(mount.R, mount.covariance);
  return fmt::format("{}{:.2f} +- {:.2f} deg{}", n.significant ? io::mount_names(n.map) + " and " : "",
                     deg(n.rest_rad.norm()), deg(n.angle_sd_rad), n.significant ? "" : " off, not significant");
}

bool says_something(const SensorMount& mount) {
  const calib::NamedMount n = calib::named(mount.R, mount.covariance);
  return mount.known() && (n.significant || !n.map.isIdentity(0.5));
}

Json to_json(const SensorMount& mount) {
  Json j{{"known", mount.known()}, {"lack", mount.known() ? Json() : Json(calib::name(mount.lack))}};
  if (mount.lack == MountLack::kMirrored) {
    const calib::Unmirrored right = calib::unmirrored(mount.R);
    j["mirrored_axis"] = std::string(1, "xyz"[right.sensor_axis]);
    j["names_once_right"] = io::mount_names(right.map);
  }
  if (!mount.known()) return j;
  const calib::NamedMount n = calib::named(mount.R, mount.covariance);
  const Quat q(mount.R);
  j["names"] = io::mount_names(n.map);
  j["remainder_rad"] = {{"angle", n.rest_rad.norm()},
                        {"angle_sd", n.angle_sd_rad},
                        {"vector", array(n.rest_rad)},
                        {"vector_sd", array(n.rest_sd_rad)},
                        {"significant", n.significant}};
  j["matrix"] = Json::array();
  for (int row = 0; row < 3; ++row) j["matrix"].push_back(array(Vec3(mount.R.row(row).transpose())));
  j["quaternion_wxyz"] = {q.w(), q.x(), q.y(), q.z()};
  j["mirror_excluded"] = mount.mirror_excluded;
  j["misfit_rad"] = mount.misfit_rad;
  return j;
}

void print(const char* sensor, const char* frame, const SensorMount& mount) {
  if (mount.lack == MountLack::kNoSensor) return;
  if (!mount.known()) {
    fmt::print("\n{}: {}\n", sensor, mount.lack == MountLack::kMirrored ? "mirrored" : "not known");
    return;
  }
  const calib::NamedMount n = calib::named(mount.R, mount.covariance);
  fmt::print("\n{} in the {}: \"{}\"\n", sensor, frame, io::mount_names(n.map));
  fmt::print("  left over {:.2f} +- {:.2f} deg, {}", deg(n.rest_rad.norm()), deg(n.angle_sd_rad),
             n.significant ? "significant" : "not significant");
  fmt::print("   about x {:+.2f} +- {:.2f}, y {:+.2f} +- {:.2f}, z {:+.2f} +- {:.2f}\n", deg(n.rest_rad[0]),
             deg(n.rest_sd_rad[0]), deg(n.rest_rad[1]), deg(n.rest_sd_rad[1]), deg(n.rest_rad[2]),
             deg(n.rest_sd_rad[2]));
  if (!n.significant) return;
  for (int row = 0; row < 3; ++row)
    fmt::print("  matrix  {:9.6f} {:9.6f} {:9.6f}\n", mount.R(row, 0), mount.R(row, 1), mount.R(row, 2));
}

void print_rests(const MountRun& run) {
  fmt::print("{:>4} {:>9} {:>9}  {:>20}  {:<16} {:>8}\n", "rest", "from s", "to s", "up, in sensor axes",
             "up in the body", "off deg");
  for (std::size_t i = 0; i < run.evidence.rests.size(); ++i) {
    const calib::MountRest& rest = run.evidence.rests[i];
    const Vec3 up = rest.acc_mps2.normalized();
    const calib::RestPose& pose = run.fit.acc.poses[i];
    fmt::print("{:>4} {:9.1f} {:9.1f}  {:+6.3f} {:+6.3f} {:+6.3f}  {:<16} {:>8}\n", i + 1, in_seconds(rest.t_start_ns),
               in_seconds(rest.t_end_ns), up.x(), up.y(), up.z(), pose_words(pose),
               pose.face && run.fit.acc.known() ? fmt::format("{:.2f}", deg(pose.off_rad)) : "");
  }
}

}  // namespace

bool MountRun::mirrored() const {
  return fit.acc.lack == MountLack::kMirrored || fit.gyr.lack == MountLack::kMirrored ||
         fit.mag.lack == MountLack::kMirrored;
}

std::string mount_yaml(const MountRun& run) {
  if (run.mirrored()) return {};
  std::string out, sensors;
  if (says_something(run.fit.gyr))
    sensors += fmt::format("    gyroscope: {}  # {}\n", value(run.fit.gyr), remark(run.fit.gyr));
  if (says_something(run.fit.mag))
    sensors += fmt::format("    magnetometer: {}  # {}\n", value(run.fit.mag), remark(run.fit.mag));
  if (!sensors.empty())
    out += "source:  # add to yours: these sit otherwise than the accelerometer\n  mount:\n" + sensors;
  if (run.fit.acc.known()) out += fmt::format("output:\n  mount: {}  # {}\n", value(run.fit.acc), remark(run.fit.acc));
  return out;
}

Json to_json(const MountRun& run) {
  Json j{{"schema", "stillpoint.mount/1"}, {"recordings", run.recordings}};
  j["rests"] = Json::array();
  for (std::size_t i = 0; i < run.evidence.rests.size(); ++i) {
    const calib::MountRest& rest = run.evidence.rests[i];
    const calib::RestPose& pose = run.fit.acc.poses[i];
    j["rests"].push_back({{"recording", run.recordings[rest.recording]},
                          {"from_s", in_seconds(rest.t_start_ns)},
                          {"to_s", in_seconds(rest.t_end_ns)},
                          {"acc_mps2", array(rest.acc_mps2)},
                          {"up_in_body", pose.face ? Json(face_name(*pose.face)) : Json()},
                          {"stated", pose.stated},
                          {"direction_only", pose.direction_only},
                          {"off_rad", pose.face && run.fit.acc.known() ? Json(pose.off_rad) : Json()}});
  }
  j["turns"] = run.evidence.turns.size();
  j["broken_turns"] = run.evidence.broken_turns;
  j["pose_sd_rad"] = run.params.pose_sd_rad;
  j["body_from_accelerometer"] = to_json(run.fit.acc);
  j["accelerometer_from_gyroscope"] = to_json(run.fit.gyr);
  j["accelerometer_from_magnetometer"] = to_json(run.fit.mag);
  j["missing"] = missing(run);
  j["yaml"] = mount_yaml(run);
  return j;
}

void print(const MountRun& run) {
  fmt::print("{}: {} rests, {} turns\n", fmt::join(run.recordings, ", "), run.evidence.rests.size(),
             run.evidence.turns.size());
  if (!run.evidence.rests.empty()) print_rests(run);
  print("accelerometer", "body", run.fit.acc);
  print("gyroscope", "accelerometer's axes", run.fit.gyr);
  print("magnetometer", "accelerometer's axes", run.fit.mag);
  fmt::print("\nstill missing:\n");
  const auto lacks = missing(run);
  for (const auto& line : lacks) fmt::print("  {}\n", line);
  if (lacks.empty()) fmt::print("  nothing\n");
  if (const std::string yaml = mount_yaml(run); !yaml.empty())
    fmt::print("\n# into the daemon's configuration\n{}", yaml);
}

}  // namespace stillpoint::app
