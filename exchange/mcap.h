/// MCAP files with ROS 2 messages: what `ros2 bag record` writes and Foxglove and PlotJuggler open.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "core/result.h"
#include "exchange/stream.h"

namespace stillpoint::exchange {

[[nodiscard]] bool is_mcap(std::string_view bytes);

/// Every sensor_msgs Imu, MagneticField and Temperature of one topic each: the one named, else the one with most
/// messages. Times are those of the messages' headers, or of the bag's log where those do not advance. Chunks may be
/// plain, lz4 or zstd. A file that ends in the middle of a record gives what is whole. Fails (65) on damage, and
/// without such a topic with the names of those it has.
[[nodiscard]] Result<std::vector<Stream>> read_mcap(std::string_view bytes, const std::string& name,
                                                    const std::string& topic, std::vector<std::string>& reasons);

}  // namespace stillpoint::exchange
