/// How Stillpoint appears on DDS. One struct serves the publisher, the subscribers and the configuration's `dds:`
/// section.
#pragma once
#include <string>
#include <vector>

#include "core/fields.h"
#include "io/dds_security.h"

namespace stillpoint::io {

struct DdsParams {
  int domain = 0;
  std::string transport = "udp";
  std::string interface = "127.0.0.1";
  std::string attitude_topic = "stillpoint/attitude";
  std::string calibration_topic = "stillpoint/calibration";
  std::string diagnostics_topic = "stillpoint/diagnostics";
  std::string raw_topic = "stillpoint/raw";
  bool own_process = false;
  bool ros2 = true;
  bool ros2_readings = true;
  std::string ros2_namespace;
  std::string frame_id = "imu_link";
  std::string name_space;
  std::vector<std::string> discovery_server;
  SecurityParams security;

  template <class P = DdsParams>
  static constexpr auto fields() {
    return std::tuple{
        field("domain", &P::domain, in_range(0, 232), "DDS domain; ROS 2 calls it ROS_DOMAIN_ID"),
        field("transport", &P::transport,
              "udp | shm | data_sharing; the last two are faster but lose everything silently between two users or two "
              "versions of Fast DDS"),
        field("interface", &P::interface,
              "address of the only network interface used; 127.0.0.1 keeps to this machine, any uses all interfaces"),
        field("attitude_topic", &P::attitude_topic, "every attitude, best effort"),
        field("calibration_topic", &P::calibration_topic, "calibration in use, reliable, kept for late subscribers"),
        field("diagnostics_topic", &P::diagnostics_topic, "health once a second, reliable"),
        field("raw_topic", &P::raw_topic, "readings as the sensor gave them, reliable; empty: not published"),
        field("own_process", &P::own_process,
              "true: DDS runs in a process of its own, and whatever ends it costs 0.2 s of publishing and no attitude; "
              "each attitude then leaves some 30 us later"),
        field("ros2", &P::ros2,
              "also publish rt/imu/data, data_raw, mag, temperature and rt/diagnostics as a ROS 2 node would"),
        field("ros2_readings", &P::ros2_readings,
              "with ros2: the readings too, as imu/data_raw, imu/mag and imu/temperature; never where the source is a "
              "ROS 2 "
              "driver, which publishes them itself"),
        field("ros2_namespace", &P::ros2_namespace, "put before imu/data and imu/mag, for example robot1"),
        field("frame_id", &P::frame_id, "frame_id of the ROS 2 messages"),
        field("namespace", &P::name_space,
              "put before every topic, for example robot1, so that several daemons share a domain; rt/diagnostics is "
              "one for all"),
        field("discovery_server", &P::discovery_server,
              "[ADDRESS:PORT, ...] of discovery servers, as in ROS_DISCOVERY_SERVER: the first is that of id 0, '' "
              "leaves an id out; empty: everybody is looked for"),
        field("security", &P::security, "DDS-Security: who is who, who may do what, and encryption (docs/dds.md)"),
    };
  }
};

/// What is wrong with the values, in words, one entry a fault; empty when they can be used.
[[nodiscard]] std::vector<std::string> check(const DdsParams& params);

/// With the namespace inside the names of the topics, and none left to be put before them.
[[nodiscard]] DdsParams in_namespace(DdsParams params);

}  // namespace stillpoint::io
