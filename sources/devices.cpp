#include "sources/devices.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>

#include "core/clock.h"
#include "core/types.h"
#include "sources/iio_device.h"
#include "sources/ros2_source.h"

namespace stillpoint::sources {
namespace {

namespace fs = std::filesystem;

constexpr std::pair<SamplePart, const char*> kParts[] = {{kAcc, "acc"}, {kGyr, "gyr"}, {kMag, "mag"}, {kTemp, "temp"}};
constexpr const char* kUnits[] = {"m/s^2", "rad/s", "uT", "degC"};

std::string details_of(const IioDevice& device) {
  std::string out = device.can_stream() ? "buffer" : "no buffer: polled";
  if (device.can_stream() && !device.has_timestamps()) out += ", no time stamps: times of arrival";
  for (std::size_t k = 0; k < std::size(kParts); ++k)
    if ((device.parts() & kParts[k].first) != 0)
      out += fmt::format(", {} step {:.3g} {}", kParts[k].second, device.step_of(kParts[k].first), kUnits[k]);
  return out;
}

void find_iio(const std::string& uri, DeviceList& out) {
  const auto context = open_iio(uri);
  if (!context) {
    out.missing.push_back({context.error().message,
                           "load the sensor's driver (lsmod | grep -i st_lsm6dsx), or describe it in the device tree; "
                           "`ls /sys/bus/iio/devices` shows what the kernel has"});
    return;
  }
  for (const IioDevice& device : IioDevice::all(**context)) {
    FoundDevice found{
        "iio", device.name(), names_of_parts(device.parts()), device.rate_hz(), details_of(device), "", "", ""};
    found.config = fmt::format("source: {{kind: iio, uri: '{}', devices: [{}]}}", uri, device.name());
    if (!device.unscaled().empty()) {
      found.problem = fmt::format("its driver does not tell the scale and offset of {}", device.unscaled());
      found.fix = "is another program busy with it, or the driver still starting? `iio_attr -c` shows what it tells";
    } else if (!device.can_stream()) {
      found.problem = "it has no buffer";
      found.fix = "wire its interrupt line and name it in the device tree; without it the values are polled (poll_hz)";
    }
    out.found.push_back(std::move(found));
  }
  if (out.found.empty())
    out.missing.push_back({fmt::format("IIO {}: no accelerometer, gyroscope or magnetometer of three axes", uri),
                           "is the driver of the sensor loaded? `iio_info` lists every device"});
}

void find_serial(DeviceList& out) {
  std::vector<std::string> paths;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator("/dev/serial/by-id", none)) paths.push_back(entry.path().string());
  if (paths.empty())
    for (const auto& entry : fs::directory_iterator("/dev", none))
      if (const std::string name = entry.path().filename().string();
          name.starts_with("ttyUSB") || name.starts_with("ttyACM") || name.starts_with("ttyAMA"))
        paths.push_back(entry.path().string());
  std::sort(paths.begin(), paths.end());
  for (const auto& path : paths) {
    FoundDevice found{
        "serial", path, "", 0.0, "", fmt::format("source: {{kind: stream, from: '{}', baud: 115200}}", path), "", ""};
    if (access(path.c_str(), R_OK) != 0) {
      found.problem = "you may not read it";
      found.fix = "sudo usermod -aG dialout $USER, then log in again";
    }
    out.found.push_back(std::move(found));
  }
  if (paths.empty())
    out.missing.push_back({"no serial line (ttyUSB, ttyACM, ttyAMA)", "plug it in; `dmesg | tail` says why not"});
}

void find_ros2(const io::DdsParams& dds, double listen_s, DeviceList& out) {
  if (listen_s <= 0.0) return;
  auto source = Ros2Source::create({}, dds);
  if (!source) {
    out.missing.push_back({source.error().message, "name another interface or domain"});
    return;
  }
  std::uint8_t parts = 0;
  int imus = 0;
  std::int64_t first_ns = 0, last_ns = 0;
  const std::int64_t until_ns = monotonic_ns() + static_cast<std::int64_t>(1e9 * listen_s);
  for (pipeline::Arrival arrival; monotonic_ns() < until_ns;) {
    if (source->next(arrival) != pipeline::SourceState::kSample) continue;
    parts = static_cast<std::uint8_t>(parts | arrival.sample.has);
    if (!arrival.sample.holds(kAcc) && !arrival.sample.holds(kGyr)) continue;
    if (imus++ == 0) first_ns = arrival.arrival_ns;
    last_ns = arrival.arrival_ns;
  }
  const io::Ros2Params topics;
  if (parts == 0) {
    out.missing.push_back({fmt::format("no ROS 2 driver on {} or {} in domain {} within {} s", topics.imu_topic,
                                       topics.mag_topic, dds.domain, listen_s),
                           "`ros2 topic list` shows its names: give them as imu_topic and mag_topic"});
    return;
  }
  const double rate_hz = imus > 1 ? 1e9 * (imus - 1) / static_cast<double>(last_ns - first_ns) : 0.0;
  out.found.push_back({"ros2", topics.imu_topic + " " + topics.mag_topic, names_of_parts(parts), rate_hz, "",
                       fmt::format("source: {{kind: ros2, domain: {}}}", dds.domain), "", ""});
}

}  // namespace

std::string names_of_parts(std::uint8_t parts) {
  std::string out;
  for (const auto& [part, name] : kParts)
    if ((parts & part) != 0) out += fmt::format("{}{}", out.empty() ? "" : " ", name);
  return out;
}

DeviceList list_devices(const std::string& uri, const io::DdsParams& dds, double listen_s) {
  DeviceList out;
  find_iio(uri, out);
  find_serial(out);
  find_ros2(dds, listen_s, out);
  return out;
}

}  // namespace stillpoint::sources
