/// What a recording for the mounting holds: the rests, and what gyroscope and magnetometer saw on the way from one to
/// the next. Offline: may allocate.
#pragma once
#include <span>
#include <vector>

#include "calib_online/preintegration.h"
#include "calib_online/rest_detector.h"

namespace stillpoint::calib {

/// One placement of the body; windows between which it hardly turned are one.
struct MountRest {
  std::size_t recording = 0;
  std::int64_t t_start_ns = 0, t_end_ns = 0;
  int windows = 0;
  Vec3 acc_mps2 = Vec3::Zero(), gyr_radps = Vec3::Zero(), mag_uT = Vec3::Zero();  ///< means of the raw readings
  double acc_var = 0.0;                                                           ///< of the mean, an axis
  bool has_gyr = false, has_mag = false;
};

/// The way from the beginning of a turn to one of its points, in the gyroscope's axes.
struct MountWay {
  Preintegrated as_read;  ///< v_start = R v_here
  Preintegrated negated;  ///< the same if all rates have the other sign: what a mirrored gyroscope would have to read
  double duration_s = 0.0;
  Vec3 acc_mps2 = Vec3::Zero(), mag_uT = Vec3::Zero();
  bool has_mag = false;
};

struct MountTurn {
  std::size_t from = 0, to = 0;  ///< rests
  MountWay whole;
  std::vector<MountWay> points;  ///< on the way, about 10 deg apart
};

struct MountEvidence {
  std::vector<MountRest> rests;
  std::vector<MountTurn> turns;
  std::size_t broken_turns = 0;  ///< the gyroscope did not see the whole way
  bool has_gyr = false, has_mag = false;
};

/// Recordings in the order in which they were made; no turn leads from one to the next.
[[nodiscard]] MountEvidence mount_evidence(std::span<const std::vector<RawSample>> recordings,
                                           const RestDetectorParams& params = {});

}  // namespace stillpoint::calib
