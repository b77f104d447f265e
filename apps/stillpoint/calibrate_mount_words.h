/// The words of `stillpoint calibrate --mount`.
#pragma once
#include <string>

#include "calib_online/offline/mount_fit.h"

namespace stillpoint::app {

/// "+x"
[[nodiscard]] std::string face_name(const Vec3& face);
/// "+x, stated"
[[nodiscard]] std::string pose_words(const calib::RestPose& pose);

}  // namespace stillpoint::app
