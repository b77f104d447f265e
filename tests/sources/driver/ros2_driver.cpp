/// A driver as ROS 2 has them, for the tests: `ros2_driver DOMAIN SAMPLES RATE_HZ [KEYS [VARIANCE]]` publishes
/// imu/data_raw, and imu/mag at a fifth of the rate. KEYS is its folder for DDS-Security, empty for none; VARIANCE is
/// stated of the rate, (rad/s)^2. Printed at the end: how many samples it sent before it had met a subscriber.
#include <stillpoint_idl/ros2PubSubTypes.h>

#include <cstdio>
#include <cstdlib>

#include "core/clock.h"
#include "io/dds_entities.h"
#include "pipeline/clock.h"

int main(int argc, char** argv) {
  using namespace stillpoint;
  if (argc < 4 || argc > 6) return 64;
  io::DdsParams params;
  params.domain = std::atoi(argv[1]);
  if (argc >= 5) params.security.folder = argv[4];
  const double variance = argc == 6 ? std::atof(argv[5]) : 0.0;
  const int samples = std::atoi(argv[2]), rate_hz = std::atoi(argv[3]);
  const auto entities = io::DdsEntities::create(params, "udp", "driver");
  if (!entities) return std::fprintf(stderr, "%s\n", entities.error().message.c_str()), 69;
  const io::dds::TypeSupport imu_type(new sensor_msgs::msg::ImuPubSubType);
  const io::dds::TypeSupport mag_type(new sensor_msgs::msg::MagneticFieldPubSubType);
  const auto imu_writer = (*entities)->writer("rt/imu/data_raw", imu_type, io::reliable_writer_qos(64, false));
  const auto mag_writer = (*entities)->writer("rt/imu/mag", mag_type, io::reliable_writer_qos(64, false));
  if (!imu_writer) return std::fprintf(stderr, "%s\n", imu_writer.error().message.c_str()), 69;
  if (!mag_writer) return std::fprintf(stderr, "%s\n", mag_writer.error().message.c_str()), 69;
  const std::int64_t start_ns = monotonic_ns();
  int alone = 0;
  for (int k = 0; k < samples; ++k) {
    io::dds::PublicationMatchedStatus met;
    (*imu_writer)->get_publication_matched_status(met);
    if (met.total_count == 0) ++alone;
    pipeline::sleep_until_ns(start_ns + 1'000'000'000LL * k / rate_hz);
    const std::int64_t stamp_ns = clock_ns(CLOCK_REALTIME);
    std_msgs::msg::Header header;
    header.stamp().sec(static_cast<std::int32_t>(stamp_ns / 1'000'000'000));
    header.stamp().nanosec(static_cast<std::uint32_t>(stamp_ns % 1'000'000'000));
    sensor_msgs::msg::Imu imu;
    imu.header(header);
    const double noise = 0.001 * (k * 7 % 11 - 5);  // a living sensor never repeats itself for long
    imu.linear_acceleration().z(9.8 + noise);
    imu.angular_velocity().x(0.1 * noise);
    imu.angular_velocity_covariance() = {variance, 0, 0, 0, variance, 0, 0, 0, variance};
    (*imu_writer)->write(&imu);
    if (k % 5 != 0) continue;
    sensor_msgs::msg::MagneticField mag;
    mag.header(header);
    mag.magnetic_field().x(20e-6);
    mag.magnetic_field().z(-43e-6);
    (*mag_writer)->write(&mag);
  }
  std::printf("%d\n", alone);
}
