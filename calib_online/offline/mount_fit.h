/// How accelerometer, gyroscope and magnetometer sit on the body, from rests in stated poses and the turns between
/// them: Wahba's problem for the accelerometer, gravity carried by the gyroscope for that, dm/dt = -w x m for the
/// magnetometer (docs/math/mount.md, U1-U6). Of each sensor also says what the evidence leaves open. Offline: may
/// allocate.
#pragma once
#include <optional>
#include <string_view>
#include <vector>

#include "calib_online/offline/mount_evidence.h"
#include "core/fields.h"
#include "core/units.h"

namespace stillpoint::calib {

/// Standard deviations of what is not known beforehand.
struct MountParams {
  double pose_sd_rad = 1.0 * kRadPerDeg;  ///< of a placement, about each of the two axes that tilt it
  double acc_bias_sd_mps2 = 0.15;
  double acc_shape_sd = 0.005;  ///< of a direction, from scales and angles of the axes
  double gyr_shape_sd = 0.02;   ///< scale and shear
  double gyr_way_sd_rad = 0.003;
  double motion_sd = 0.08;     ///< of gravity's direction as read while the body turns, from its acceleration
  double mag_shape_sd = 0.05;  ///< scale and shear, soft iron in them
  double hard_iron_sd_uT = 100.0;
  double field_sd = 0.02;                  ///< of a reading on the way, relative to the field
  double alike_rad = 30.0 * kRadPerDeg;    ///< poses nearer than this are one pose, or its opposite
  double face_rad = 25.0 * kRadPerDeg;     ///< a further rest within this of a face has that face up
  double open_sd_rad = 10.0 * kRadPerDeg;  ///< an axis that is known no better is not known
  /// Body axes that are up, in the order of the rests; the first is the body as it stands.
  std::vector<Vec3> faces{Vec3::UnitZ(), Vec3::UnitX()};
  std::optional<bool> north;  ///< of the magnetic equator, where that is known
};

enum class MountLack : std::uint8_t {
  kNone,
  kNoSensor,  ///< the recordings do not have it
  kNoRest,
  kOnePose,        ///< all rests have the same direction up, or its opposite
  kNoTurn,         ///< no whole way between two rests
  kOneAxis,        ///< turns about one axis leave the rotation about that axis open
  kAmbiguous,      ///< several maps fit alike
  kContradiction,  ///< no map fits
  kNoGyroscope,    ///< the magnetometer's axes need those of the gyroscope
  kFieldLevel,     ///< without a field that dips the magnetometer's sign is open
  kMirrored,
};
[[nodiscard]] std::string_view name(MountLack lack) noexcept;

struct SensorMount {
  MountLack lack = MountLack::kNoSensor;
  bool mirror_excluded = false;  ///< a mirrored axis would have been seen
  /// Frame from sensor; the accelerometer's frame is the body, that of the others the accelerometer. Mirrored sensors
  /// have det -1.
  Mat3 R = Mat3::Identity();
  Mat3 covariance = Mat3::Zero();  ///< rad^2, axes of the frame
  double misfit_rad = 0.0;         ///< rms of what the evidence is off
  [[nodiscard]] bool known() const noexcept { return lack == MountLack::kNone; }
};

/// What was made of one rest.
struct RestPose {
  std::optional<Vec3> face;     ///< that is up in the body
  bool stated = false;          ///< by MountParams::faces, not recognised
  bool direction_only = false;  ///< tipped towards that face, but not by a right angle
  double off_rad = 0.0;         ///< between the face and what the mount makes of the rest
};

struct AccMount : SensorMount {
  std::vector<RestPose> poses;  ///< one a rest
  Vec3 bias_mps2 = Vec3::Zero();
  double bias_sd_mps2 = 0.0;
};

struct MagMount : SensorMount {
  double dip_sine = 0.0;  ///< of the field's angle below the horizon
};

struct MountFit {
  AccMount acc;
  SensorMount gyr;
  MagMount mag;
};

[[nodiscard]] MountFit fit_mount(const MountEvidence& evidence, const MountParams& params = {});

[[nodiscard]] AccMount fit_acc_mount(const MountEvidence& evidence, const MountParams& params);
[[nodiscard]] SensorMount fit_gyr_mount(const MountEvidence& evidence, const AccMount& acc, const MountParams& params);
[[nodiscard]] MagMount fit_mag_mount(const MountEvidence& evidence, const AccMount& acc, const SensorMount& gyr,
                                     const MountParams& params);

/// A rotation as axes that a configuration names, and what is left of it.
struct NamedMount {
  Mat3 map = Mat3::Identity();
  Vec3 rest_rad = Vec3::Zero();  ///< R = exp(rest) map, axes of the frame
  Vec3 rest_sd_rad = Vec3::Zero();
  double angle_sd_rad = 0.0;  ///< of the length of `rest_rad`
  bool significant = false;   ///< at 99 %
};
[[nodiscard]] NamedMount named(const Mat3& R, const Mat3& covariance);

}  // namespace stillpoint::calib
