/// How a sensor sits in a frame: three signed axes, a matrix or a quaternion. What mirrors is refused.
#pragma once
#include <string>
#include <variant>

#include "core/types.h"

namespace stillpoint::io {

/// Rotation from the sensor's axes to the frame's: v_frame = R v_sensor.
struct Mount {
  Mat3 R_body_sensor = Mat3::Identity();
};

/// "+x -z +y": frame x is the sensor's +x, frame y its -z, frame z its +y. The text says what is wrong, and what is the
/// nearest that is right.
[[nodiscard]] std::variant<Mount, std::string> mount_of_names(const std::string& text);
/// Any matrix within 1e-3 of a rotation is taken for the nearest one.
[[nodiscard]] std::variant<Mount, std::string> mount_of_matrix(const Mat3& matrix);

/// "+x -z +y" of a matrix that has one entry of +-1 in each row.
[[nodiscard]] std::string mount_names(const Mat3& axes);

}  // namespace stillpoint::io
