/// What can be attached here: IIO devices, serial lines, ROS 2 drivers; what each gives, and what stands in the way.
#pragma once
#include <string>
#include <vector>

#include "io/dds_params.h"

namespace stillpoint::sources {

struct FoundDevice {
  std::string kind;      ///< iio, serial or ros2, as in `source: kind`
  std::string name;      ///< as the configuration names it
  std::string parts;     ///< "acc gyr mag temp"; empty where only reading tells
  double rate_hz = 0.0;  ///< 0: not known
  std::string detail;
  std::string config;        ///< the `source:` line for it
  std::string problem, fix;  ///< empty: it can be used
};

struct MissingThing {
  std::string what, fix;
};

struct DeviceList {
  std::vector<FoundDevice> found;
  std::vector<MissingThing> missing;
};

/// `uri` is that of IIO; `listen_s` how long drivers are listened for, 0: not at all.
[[nodiscard]] DeviceList list_devices(const std::string& uri, const io::DdsParams& dds, double listen_s);

/// "acc gyr", from bits of SamplePart.
[[nodiscard]] std::string names_of_parts(std::uint8_t parts);

}  // namespace stillpoint::sources
