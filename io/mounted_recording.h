/// A recording whose sensors sit in other axes than those of the common sensor frame, as `source: mount` says.
#pragma once
#include "io/recording.h"
#include "io/source_config.h"

namespace stillpoint::io {

/// Every reading turned into the common sensor frame, as the daemon turns its source's.
inline void mount_sensors(Recording& recording, const SensorMounts& mounts) {
  const auto turn = [](const Mount& mount, std::vector<Vec3>& readings) {
    for (Vec3& reading : readings) reading = mount.R_body_sensor * reading;
  };
  turn(mounts.accelerometer, recording.acc_mps2);
  turn(mounts.gyroscope, recording.gyr_radps);
  turn(mounts.magnetometer, recording.mag_uT);
}

}  // namespace stillpoint::io
