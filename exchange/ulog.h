/// PX4's flight logs (.ulg): raw accelerometer, gyroscope, magnetometer and their temperature.
#pragma once
#include <string>
#include <vector>

#include "exchange/stream.h"

namespace stillpoint::exchange {

[[nodiscard]] bool is_ulog(std::string_view bytes);

/// First instances of sensor_accel, sensor_gyro and sensor_mag; where they were not logged, or clearly slower,
/// sensor_combined and vehicle_magnetometer. Turned from forward-right-down to x forward, y left, z up. A log that ends
/// in the middle of a message gives what is whole. Fails (65) on a damaged head and where none of these topics is in
/// it.
[[nodiscard]] Result<std::vector<Stream>> read_ulog(std::string_view bytes, const std::string& name,
                                                    std::vector<std::string>& reasons);

}  // namespace stillpoint::exchange
