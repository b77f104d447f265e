#include "apps/stillpoint/calibrate_mount_words.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/stillpoint/calibrate_mount_report.h"
#include "calib_online/offline/axis_maps.h"
#include "core/units.h"
#include "io/mount.h"

namespace stillpoint::app {
namespace {

using calib::MountLack;
using calib::SensorMount;

std::string mirrored_words(const SensorMount& mount, const char* frame) {
  const calib::Unmirrored right = calib::unmirrored(mount.R);
  return fmt::format(
      "mirrored against {}: nearest is \"{}\", which no rotation reaches; most likely its {} reads with the "
      "wrong sign: multiply it by -1 where it is read, then mount \"{}\"",
      frame, io::mount_names(calib::nearest_axis_map(mount.R)), "xyz"[right.sensor_axis], io::mount_names(right.map));
}

std::string acc_words(const MountRun& run) {
  const calib::AccMount& acc = run.fit.acc;
  const auto tipped = [&run] {
    for (const Vec3& face : run.params.faces)
      if (face.cross(run.params.faces.front()).norm() > 0.5) return face_name(face);
    return std::string();
  };
  switch (acc.lack) {
    case MountLack::kNoRest:
      return "no rest: leave the body for 3 s in each pose, on something firm";
    case MountLack::kOnePose:
      return fmt::format(
          "{}; level is seen, forward is not: tip the body so that its {} is up and leave it for 3 s",
          run.evidence.rests.size() == 1 ? "only one rest" : "all rests have one side up or down, within 30 deg",
          tipped());
    case MountLack::kMirrored:
      return mirrored_words(acc, "the stated faces");
    default:
      return "";
  }
}

/// What gyroscope and magnetometer lack alike.
std::string turn_words(const MountRun& run, const SensorMount& mount) {
  switch (mount.lack) {
    case MountLack::kNoRest:
      return "no rest";
    case MountLack::kNoTurn:
      return run.evidence.broken_turns > 0
                 ? "readings are missing in every turn from one rest to the next: record without gaps"
                 : "no turn: its axes show while the body is turned from one rest to the next; keep all poses in one "
                   "recording";
    case MountLack::kOneAxis:
      return "all turns are about one axis, or it hardly sees them: add a rest on another side, such as left side up, "
             "in the same recording";
    case MountLack::kAmbiguous:
      return "the turns fit several maps alike: add turns about the other axes, such as front up to left side up";
    default:
      return "";
  }
}

std::string gyr_words(const MountRun& run) {
  const SensorMount& gyr = run.fit.gyr;
  if (gyr.lack == MountLack::kNoSensor) return "not in the recording; taken to sit as the accelerometer does";
  if (gyr.lack == MountLack::kMirrored) return mirrored_words(gyr, "the accelerometer");
  if (gyr.lack == MountLack::kContradiction)
    return fmt::format(
        "no map carries gravity over the turns, best is {:.1f} deg off: is its unit right, does it clip?",
        gyr.misfit_rad * kDegPerRad);
  if (gyr.known() && !gyr.mirror_excluded)
    return "that no axis is mirrored is taken for granted: turns about three axes would show it (level, front up, left "
           "side up, level)";
  return turn_words(run, gyr);
}

std::string mag_words(const MountRun& run) {
  const calib::MagMount& mag = run.fit.mag;
  const double dip_deg = std::asin(std::clamp(mag.dip_sine, -1.0, 1.0)) * kDegPerRad;
  switch (mag.lack) {
    case MountLack::kNoSensor:
      return "";
    case MountLack::kNoGyroscope:
      return "needs the gyroscope's axes";
    case MountLack::kContradiction:
      return "no map turns the field as the gyroscope says: is there steel or a current nearby? Repeat a metre away";
    case MountLack::kFieldLevel:
      return fmt::format("the field dips by {:.0f} deg only: whether it is mirrored cannot be told here", dip_deg);
    case MountLack::kMirrored:
      return mirrored_words(mag, "the accelerometer") +
             (run.params.north
                  ? std::string()
                  : fmt::format("; or this is south of the magnetic equator, where the field points up ({:.0f} deg): "
                                "then state --latitude",
                                -dip_deg));
    case MountLack::kNone:
      return run.params.north ? std::string()
                              : "taken to be north of the magnetic equator; state --latitude if it is not";
    default:
      return turn_words(run, mag);
  }
}

}  // namespace

std::string face_name(const Vec3& face) {
  Eigen::Index axis = 0;
  face.cwiseAbs().maxCoeff(&axis);
  return fmt::format("{}{}", face[axis] < 0.0 ? '-' : '+', "xyz"[axis]);
}

std::string pose_words(const calib::RestPose& pose) {
  if (!pose.face) return "between faces";
  return fmt::format("{}{}{}", pose.direction_only ? "towards " : "", face_name(*pose.face),
                     pose.stated ? ", stated" : "");
}

std::vector<std::string> missing(const MountRun& run) {
  std::vector<std::string> out;
  const auto add = [&out](const char* sensor, const std::string& words) {
    if (!words.empty()) out.push_back(std::string(sensor) + ": " + words);
  };
  add("accelerometer", acc_words(run));
  for (std::size_t i = 0; i < run.fit.acc.poses.size(); ++i)
    if (run.fit.acc.poses[i].direction_only)
      add("accelerometer",
          fmt::format("rest {} is not tipped by a right angle; only where it was tipped to is used", i + 1));
  add("gyroscope", gyr_words(run));
  add("magnetometer", mag_words(run));
  return out;
}

}  // namespace stillpoint::app
