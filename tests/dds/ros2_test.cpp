#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <sstream>
#include <thread>

#include "io/dds_convert.h"
#include "io/dds_publisher.h"
#include "tests/apps/apps_testing.h"
#include "tests/dds/dds_testing.h"
#include "tests/dds/process.h"

namespace stillpoint {
namespace {

using test::test_params;

CalibratedSample calibrated_sample() {
  CalibratedSample s;
  s.acc_mps2 = {0.125, -0.25, 9.8};
  s.mag_uT = {20.0, -5.0, -43.0};
  s.has = kAcc | kGyr | kMag;
  return s;
}

AttitudeMessage attitude() {
  AttitudeMessage m = test::attitude_message(3);
  for (std::size_t i = 0; i < 9; ++i) m.orientation_covariance_rad2[i] = 0.001 * static_cast<double>(i + 1);
  m.rate_radps = {0.1, 0.2, 0.3};
  m.t_arrival_ns = 0;  // stamped with now
  return m;
}

const std::string kFrame = "imu_link";

ReadingCovariances covariances() {
  ReadingCovariances c;
  for (std::size_t i = 0; i < 9; ++i) {
    c.acc_mps2_2[i] = 0.1 * static_cast<double>(i + 1);
    c.gyr_radps_2[i] = 0.2 * static_cast<double>(i + 1);
    c.mag_uT_2[i] = 0.3 * static_cast<double>(i + 1);
  }
  return c;
}

TEST(Ros2, ImuFollowsRep145) {
  sensor_msgs::msg::Imu imu;
  io::to_ros2(attitude(), calibrated_sample(), covariances(), {12'000'000'034, kFrame}, imu);
  EXPECT_EQ(imu.header().stamp().sec(), 12);
  EXPECT_EQ(imu.header().stamp().nanosec(), 34U);
  EXPECT_EQ(imu.orientation().w(), attitude().q_world_body_xyzw[3]);
  EXPECT_EQ(imu.linear_acceleration().z(), 9.8) << "specific force: +g upwards at rest";
  EXPECT_EQ(imu.linear_acceleration_covariance(), covariances().acc_mps2_2);
  EXPECT_EQ(imu.angular_velocity_covariance(), covariances().gyr_radps_2);
  EXPECT_EQ(imu.orientation_covariance(), attitude().orientation_covariance_rad2);

  CalibratedSample without_acc = calibrated_sample();
  without_acc.has = kGyr;
  AttitudeMessage none = attitude();
  none.status = AttitudeStatus::kInitializing;
  io::to_ros2(none, without_acc, {}, {0, kFrame}, imu);
  EXPECT_EQ(imu.linear_acceleration_covariance()[0], -1.0) << "absent";
  EXPECT_EQ(imu.orientation_covariance()[0], -1.0) << "no attitude yet";
  EXPECT_EQ(imu.angular_velocity_covariance()[0], 0.0) << "measured, error not known";
}

TEST(Ros2, TheRawImuHasNoOrientationAndTheReadingsAsTheyCame) {
  sensor_msgs::msg::Imu imu;
  const RawSample raw = test::raw_sample(3);
  io::to_ros2_raw(raw, covariances(), {5, kFrame}, imu);
  EXPECT_EQ(imu.orientation_covariance()[0], -1.0) << "absent";
  EXPECT_EQ(imu.angular_velocity().x(), raw.gyr_radps[0]);
  EXPECT_EQ(imu.linear_acceleration().y(), raw.acc_mps2[1]);
  EXPECT_EQ(imu.angular_velocity_covariance(), covariances().gyr_radps_2);
}

TEST(Ros2, TheTemperatureIsInDegreesCelsius) {
  sensor_msgs::msg::Temperature temperature;
  io::to_ros2(21.5, {7, kFrame}, temperature);
  EXPECT_EQ(temperature.temperature(), 21.5);
  EXPECT_EQ(temperature.variance(), 0.0) << "not known";
  EXPECT_EQ(temperature.header().frame_id(), kFrame);
}

TEST(Ros2, TheMagneticFieldIsInTesla) {
  sensor_msgs::msg::MagneticField field;
  io::to_ros2(calibrated_sample(), covariances(), {0, kFrame}, field);
  EXPECT_DOUBLE_EQ(field.magnetic_field_covariance()[4], 1.5e-12);
  EXPECT_DOUBLE_EQ(field.magnetic_field().x(), 20e-6);
  EXPECT_DOUBLE_EQ(field.magnetic_field().z(), -43e-6);
}

TEST(Ros2, DiagnosticsCarryALevelOfRep107) {
  diagnostic_msgs::msg::DiagnosticArray array;
  DiagnosticsMessage message = test::diagnostics_message();
  io::to_ros2(message, 0, array);
  ASSERT_EQ(array.status().size(), 1U);
  EXPECT_EQ(array.status()[0].level(), 2) << "a sensor is faulty";
  message.health = {};
  io::to_ros2(message, 0, array);
  EXPECT_EQ(array.status()[0].level(), 1) << "something is missing";
  message.missing.clear();
  io::to_ros2(message, 0, array);
  EXPECT_EQ(array.status()[0].level(), 0);
  message.status = AttitudeStatus::kStale;
  io::to_ros2(message, 0, array);
  ASSERT_EQ(array.status().size(), 1U) << "the array is not appended to";
  EXPECT_EQ(array.status()[0].level(), 3);
}

void keep_cyclone_on_loopback() {
  setenv("CYCLONEDDS_URI",
         "<Domain><General><Interfaces><NetworkInterface address='127.0.0.1'/></Interfaces>"
         "<AllowMulticast>false</AllowMulticast></General><Discovery><ParticipantIndex>auto</ParticipantIndex>"
         "<Peers><Peer address='127.0.0.1'/></Peers></Discovery></Domain>",
         1);
}

TEST(Ros2, ASubscriberOfAnotherVendorReadsEveryFieldAndTheTypeHash) {
  if (std::string(CYCLONE_READER).empty())
    GTEST_SKIP() << "LOUD: SKIPPED: no Cyclone DDS was found when this was configured (apt-get install cyclonedds-dev "
                    "cyclonedds-tools)";
  keep_cyclone_on_loopback();
  auto publisher = io::DdsPublisher::create(test_params());
  ASSERT_TRUE(publisher) << publisher.error().message;
  test::Process reader({CYCLONE_READER, std::to_string(test_params().domain)});
  std::atomic<bool> stop{false};
  std::thread writer([&] {
    while (!stop) {
      (*publisher)->publish_imu({attitude(), calibrated_sample(), test::raw_sample(0), covariances()});
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
  });
  const std::string said = reader.output();
  const int code = reader.wait();
  stop = true;
  writer.join();
  ASSERT_EQ(code, 0) << "no message arrived";
  EXPECT_THAT(said,
              testing::HasSubstr("typehash=RIHS01_7d9a00ff131080897a5ec7e26e315954b8eae3353c3f995c55faf71574000b5b;"));
  std::istringstream fields(said.substr(said.find('\n') + 1));
  std::string frame;
  double sec = 0, nanosec = 0;
  fields >> frame >> sec >> nanosec;
  EXPECT_EQ(frame, "imu_link");
  EXPECT_NEAR(sec, static_cast<double>(time(nullptr)), 60.0) << "the stamp is wall time";
  std::vector<double> got;
  for (double x = 0; fields >> x;) got.push_back(x);
  std::vector<double> expected;
  const auto add = [&expected](const auto& values) { expected.insert(expected.end(), values.begin(), values.end()); };
  add(attitude().q_world_body_xyzw);
  add(attitude().orientation_covariance_rad2);
  add(attitude().rate_radps);
  add(covariances().gyr_radps_2);
  add(calibrated_sample().acc_mps2);
  add(covariances().acc_mps2_2);
  EXPECT_EQ(got, expected);
}

/// The sensor lies on its side, mounted so that the body stands upright.
TEST(Ros2, OfAMountedSensorTheDaemonPublishesTheForceInTheBodysAxes) {
  if (std::string(CYCLONE_READER).empty()) GTEST_SKIP() << "LOUD: SKIPPED: no Cyclone DDS was found";
  keep_cyclone_on_loopback();
  const test::ScratchFolder folder;
  std::string recording = "time_s,acc_x_mps2,acc_y_mps2,acc_z_mps2,gyr_x_radps,gyr_y_radps,gyr_z_radps\n";
  for (int k = 0; k < 3000; ++k) recording += std::to_string(0.02 * k) + ",9.81,0.0,0.0,0.1,0.0,0.0\n";
  test::write_file(folder / "r.csv", recording);
  test::write_file(folder / "d.yaml",
                   "source: {kind: recording, file: r.csv, speed: 1}\ncalibration: {enabled: false}\noutput: {mount: "
                   "\"+y +z +x\"}\ndds: {domain: " +
                       std::to_string(test_params().domain) + "}\n");
  test::Process daemon({STILLPOINTD, "--config", folder / "d.yaml"}, folder / "log");
  test::Process reader({CYCLONE_READER, std::to_string(test_params().domain)});
  const std::string said = reader.output();
  ASSERT_EQ(reader.wait(), 0) << said << test::read_file(folder / "log");
  std::istringstream fields(said.substr(said.find("imu_link")));
  std::string frame;
  fields >> frame;
  std::vector<double> got;
  for (double x = 0; fields >> x;) got.push_back(x);
  ASSERT_EQ(got.size(), 2U + 4U + 3U * 9U + 6U) << said;
  const Quat q_world_body(got[5], got[2], got[3], got[4]);
  const Vec3 rate(got[15], got[16], got[17]), force(got[27], got[28], got[29]);
  EXPECT_LT((force - Vec3(0, 0, 9.81)).norm(), 0.01) << force.transpose();
  EXPECT_LT(rate.head<2>().norm(), 0.01) << rate.transpose();  // about z it may have been learnt as a bias by now
  EXPECT_LT((q_world_body * force - Vec3(0, 0, 9.81)).norm(), 0.1);
  daemon.send(SIGTERM);
  daemon.wait();
}

}  // namespace
}  // namespace stillpoint
