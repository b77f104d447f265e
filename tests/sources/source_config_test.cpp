#include "io/source_config.h"

#include <gtest/gtest.h>

#include "io/config.h"

namespace stillpoint::io {
namespace {

std::string faults(const std::string& source) {
  const auto config = parse_config("source: " + source + "\n", "f.yaml");
  return config ? "no fault" : config.error().message;
}

TEST(SourceConfig, EachKindHasItsOwnKeys) {
  EXPECT_EQ(faults("{kind: stream, from: stdin, columns: [time_ms, acc_x_g, acc_y_g, acc_z_g]}"), "no fault");
  EXPECT_EQ(faults("{kind: ros2, domain: 3, mag_topic: ''}"), "no fault");
  EXPECT_EQ(faults("{kind: iio, uri: 'ip:127.0.0.1:40000', devices: [lsm6dsx_accel, lsm6dsx_gyro]}"), "no fault");
  EXPECT_NE(faults("{kind: recording, file: a.csv, baud: 9600}").find("f.yaml:1:40: unknown key 'baud'"),
            std::string::npos);
  EXPECT_NE(faults("{kind: stream}").find("'from' is missing here"), std::string::npos);
  EXPECT_NE(faults("{kind: stream, from: ''}").find("'from' is empty"), std::string::npos);
  EXPECT_NE(faults("{kind: serial, from: a}").find("'kind' cannot be 'serial'; known here"), std::string::npos);
  EXPECT_NE(faults("{from: a}").find("'kind' is missing here"), std::string::npos);
  EXPECT_NE(faults("{kind: ros2, imu_topic: '', mag_topic: ''}").find("neither"), std::string::npos);
}

TEST(SourceConfig, ColumnsAreCheckedByName) {
  EXPECT_NE(faults("{kind: stream, from: stdin, columns: {acc_x: 1}}").find("'acc_x' lacks its unit"),
            std::string::npos);
  EXPECT_NE(faults("{kind: stream, from: stdin, columns: [ref_qw]}").find("'ref_qw' is no reading"), std::string::npos);
  EXPECT_NE(faults("{kind: stream, from: stdin, columns: [gyr_x_counts]}").find("needs 'gyr_radps_per_count'"),
            std::string::npos);
  EXPECT_EQ(faults("{kind: stream, from: stdin, columns: [gyr_x_counts], gyr_radps_per_count: 0.001}"), "no fault");
}

TEST(SourceConfig, PlacesOfColumnsAreCheckedForWhatTheyCanBe) {
  const auto columns = [](const std::string& map) {
    return faults("{kind: stream, from: stdin, columns: " + map + "}");
  };
  EXPECT_EQ(columns("{time_ms: 1, acc_x_g: 64}"), "no fault");
  EXPECT_EQ(columns("{time_ms: t, acc_x_g: 3d}"), "no fault");
  for (const char* position : {"0", "-1", "1e9", "65", "1.5"})
    EXPECT_EQ(columns(std::string("{acc_x_g: ") + position + "}"),
              std::string("f.yaml:1:56: 'acc_x_g' is at position ") + position +
                  "; positions are whole numbers from 1 to 64");
  EXPECT_EQ(columns("{acc_x_g: 2, acc_y_g: 2}"), "f.yaml:1:68: 'acc_x_g' and 'acc_y_g' are both taken from '2'");
  EXPECT_EQ(columns("{acc_x_g: a, acc_y_g: a}"), "f.yaml:1:68: 'acc_x_g' and 'acc_y_g' are both taken from 'a'");
  EXPECT_EQ(columns("[time_ms, acc_x_g, acc_x_g]"),
            "f.yaml:1:46: 'acc_x_g' and 'acc_x_g' are the same reading; name it once");
  EXPECT_EQ(columns("{time_ms: 1, time_s: 2}"),
            "f.yaml:1:67: 'time_ms' and 'time_s' are the same reading; name it once");
  EXPECT_EQ(columns("{time_ms: 1, acc_x_g: ax}"),
            "f.yaml:1:46: names and positions are mixed; give the name of each, or the position of each");
}

TEST(SourceConfig, AKindThatIsMisspeltIsAllThatIsTold) {
  EXPECT_EQ(faults("{kind: strem, from: stdin}"), "f.yaml:1:16: 'kind' cannot be 'strem'; did you mean 'stream'?");
}

TEST(SourceConfig, PrintedItReadsBackToTheSame) {
  for (const char* source :
       {"{kind: stream, from: /dev/ttyUSB0, baud: 921600, columns: {time_ms: t, acc_x_g: \"it's\"}, at_end: wait}",
        "{kind: ros2, imu_topic: a/b}", "{kind: iio, devices: [a, b]}",
        "{kind: stream, from: 'udp://:5', mount: {gyroscope: \"+y -x +z\"}}"}) {
    const auto config = parse_config(std::string("source: ") + source + "\n", "/f.yaml");
    ASSERT_TRUE(config) << config.error().message;
    const std::string text = print_config(*config);
    const auto again = parse_config(text, "/g.yaml");
    ASSERT_TRUE(again) << again.error().message << text;
    EXPECT_EQ(print_config(*again), text);
    EXPECT_EQ(again->source.kind, config->source.kind);
    EXPECT_EQ(again->source.stream.columns, config->source.stream.columns);
  }
}

TEST(SourceConfig, PathsAreRelativeToTheConfigurationAddressesAreNot) {
  const auto from = [](const std::string& text) {
    return parse_config("source: {kind: stream, from: '" + text + "'}", "folder/f.yaml")->source.stream.from;
  };
  EXPECT_EQ(from("imu.fifo"), "folder/imu.fifo");
  EXPECT_EQ(from("/dev/ttyUSB0"), "/dev/ttyUSB0");
  EXPECT_EQ(from("stdin"), "stdin");
  EXPECT_EQ(from("udp://:5555"), "udp://:5555");
}

TEST(SourceConfig, MountsBySensorAndAMirroredOneIsAnsweredWithThoseNearIt) {
  const auto config = parse_config(
      "source: {kind: stream, from: stdin, mount: {accelerometer: \"+y -x +z\", gyroscope: [0.7071068, 0, 0, "
      "0.7071068], "
      "magnetometer: [[0, 0, 1], [1, 0, 0], [0, 1, 0]]}}",
      "f.yaml");
  ASSERT_TRUE(config) << config.error().message;
  const SensorMounts& mounts = *config->source.mount;
  EXPECT_EQ(Vec3(mounts.accelerometer.R_body_sensor * Vec3(1, 2, 3)), Vec3(2, -1, 3));
  EXPECT_TRUE(Vec3(mounts.gyroscope.R_body_sensor * Vec3(1, 2, 3)).isApprox(Vec3(-2, 1, 3), 1e-6));
  EXPECT_TRUE(Vec3(mounts.magnetometer.R_body_sensor * Vec3(1, 2, 3)).isApprox(Vec3(3, 1, 2)));
  const std::string mirrored = faults("{kind: stream, from: stdin, mount: {magnetometer: \"+y +x +z\"}}");
  EXPECT_NE(mirrored.find("'magnetometer' mirrors"), std::string::npos) << mirrored;
  EXPECT_NE(mirrored.find("\"-y +x +z\", \"+y -x +z\", \"+y +x -z\""), std::string::npos) << mirrored;
}

}  // namespace
}  // namespace stillpoint::io
