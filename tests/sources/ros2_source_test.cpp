#include "sources/ros2_source.h"

#include <gtest/gtest.h>
#include <stillpoint_idl/ros2PubSubTypes.h>

#include <set>
#include <thread>

#include "io/dds_domain.h"
#include "io/dds_entities.h"
#include "sources/ros2_convert.h"
#include "tests/dds/process.h"
#include "tests/sources/sources_testing.h"

namespace stillpoint::sources {
namespace {

using pipeline::Arrival;
using pipeline::SourceState;

io::DdsParams in_own_domain() {
  io::DdsParams params;
  params.domain = io::own_domain();
  return params;
}

sensor_msgs::msg::Imu imu(int k) {
  sensor_msgs::msg::Imu m;
  m.header().stamp().sec(100 + k / 1000);
  m.header().stamp().nanosec(static_cast<std::uint32_t>(k % 1000) * 1'000'000);
  m.header().frame_id("imu_link");
  m.linear_acceleration().z(9.75);
  m.angular_velocity().x(0.5);
  m.orientation_covariance()[0] = -1.0;
  return m;
}

TEST(Ros2Convert, WhatACovarianceSaysIsNotMeasuredIsNoReading) {
  sensor_msgs::msg::Imu m = imu(7);
  Reading r = from_ros2(m, true);
  EXPECT_EQ(r.sample.has, kAcc | kGyr);
  EXPECT_EQ(r.sample.t_ns, 100'007'000'000);
  EXPECT_DOUBLE_EQ(r.sample.acc_mps2[2], 9.75);
  m.angular_velocity_covariance()[0] = -1.0;
  EXPECT_EQ(from_ros2(m, true).sample.has, kAcc);
  EXPECT_EQ(from_ros2(m, false).sample.has, kAcc | kGyr);
  m.linear_acceleration().x(std::numeric_limits<double>::quiet_NaN());
  EXPECT_EQ(from_ros2(m, true).sample.has, 0);
  m.header().stamp() = {};
  EXPECT_FALSE(from_ros2(m, true).has_time);
  sensor_msgs::msg::MagneticField field;
  field.magnetic_field().y(20e-6);
  r = from_ros2(field, true);
  EXPECT_EQ(r.sample.has, kMag);
  EXPECT_NEAR(r.sample.mag_uT[1], 20.0, 1e-9);
  EXPECT_EQ(dds_topic("/imu/data_raw"), "rt/imu/data_raw");
  EXPECT_EQ(dds_topic("a/imu"), "rt/a/imu");
}

TEST(Ros2Convert, APositiveCovarianceStatesTheNoiseUnlessItIsIgnored) {
  sensor_msgs::msg::Imu m = imu(0);
  EXPECT_EQ(from_ros2(m, true).noise, pipeline::StatedNoise{}) << "zeros: not known";
  m.angular_velocity_covariance() = {1e-4, 0, 0, 0, 4e-4, 0, 0, 0, 1e-4};
  m.linear_acceleration_covariance() = {0.01, 0, 0, 0, 0.01, 0, 0, 0, 0.09};
  EXPECT_DOUBLE_EQ(from_ros2(m, true).noise.gyr_radps, 0.02) << "the largest";
  EXPECT_DOUBLE_EQ(from_ros2(m, true).noise.acc_mps2, 0.3);
  EXPECT_EQ(from_ros2(m, false).noise, pipeline::StatedNoise{});
  EXPECT_EQ(from_ros2(m, true).refused_variance, 0.0);
  sensor_msgs::msg::MagneticField field;
  field.magnetic_field_covariance() = {1e-12, 0, 0, 0, 1e-12, 0, 0, 0, 4e-12};
  EXPECT_NEAR(from_ros2(field, true).noise.mag_uT, 2.0, 1e-12) << "tesla squared";
  EXPECT_EQ(from_ros2(field, false).noise.mag_uT, 0.0);
  field.magnetic_field_covariance()[0] = -1.0;
  EXPECT_EQ(from_ros2(field, true).sample.has, 0);
  EXPECT_EQ(from_ros2(field, false).sample.has, kMag);
}

TEST(Ros2Convert, ACovarianceThatNoSensorHasIsRefusedAndTheReadingServes) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  for (const double variance : {-0.5, kNaN, std::numeric_limits<double>::infinity(), 99999.0}) {
    sensor_msgs::msg::Imu m = imu(0);
    m.angular_velocity_covariance()[4] = variance;
    const Reading r = from_ros2(m, true);
    EXPECT_EQ(r.sample.has, kAcc | kGyr);
    EXPECT_EQ(r.noise, pipeline::StatedNoise{}) << variance;
    EXPECT_EQ(r.refused_part, kGyr);
    EXPECT_TRUE(r.refused_variance == variance || (std::isnan(r.refused_variance) && std::isnan(variance)));
    EXPECT_EQ(from_ros2(m, false).refused_variance, 0.0);
  }
  sensor_msgs::msg::Imu m = imu(0);
  m.linear_acceleration_covariance()[1] = kNaN;
  EXPECT_NE(from_ros2(m, true).refused_variance, 0.0) << "beside the diagonal as well";
  sensor_msgs::msg::MagneticField field;
  field.magnetic_field_covariance()[8] = 0.25;  // uT^2, given as T^2
  EXPECT_EQ(from_ros2(field, true).refused_part, kMag);
  EXPECT_EQ(from_ros2(field, true).refused_variance, 0.25);
}

TEST(Ros2Source, ADriverInAnotherProcessIsHeardGoesAndIsHeardAgain) {
  const io::DdsParams params = in_own_domain();
  auto source = Ros2Source::create({}, params);
  ASSERT_TRUE(source) << source.error().message;
  Arrival out;
  EXPECT_EQ(source->next(out), SourceState::kNothing);
  for (int run = 0; run < 2; ++run) {
    test::Process driver({ROS2_DRIVER, std::to_string(params.domain), "1500", "1000"});
    ASSERT_TRUE(driver.started());
    std::uint8_t parts = 0;
    std::int64_t last_acc_ns = 0;
    for (int k = 0; k < 600; ++k) {
      ASSERT_TRUE(test::eventually_sample(*source, out)) << "run " << run << " sample " << k;
      parts = static_cast<std::uint8_t>(parts | out.sample.has);
      if (!out.sample.holds(kAcc)) continue;
      EXPECT_TRUE(out.sample.holds(kGyr));
      EXPECT_GT(out.sample.t_ns, last_acc_ns);
      last_acc_ns = out.sample.t_ns;
    }
    EXPECT_EQ(parts, kAcc | kGyr | kMag);
    EXPECT_EQ(source->report()->try_load()->link, LinkState::kThere);
    driver.wait();
    EXPECT_TRUE(test::eventually_state(*source, out, SourceState::kGone, 15.0)) << "run " << run;
  }
}

TEST(Ros2Source, WhatThisProcessPublishesIsNotTakenForAReading) {
  const io::DdsParams params = in_own_domain();
  auto source = Ros2Source::create({}, params);
  ASSERT_TRUE(source) << source.error().message;
  auto own = io::DdsEntities::create(params, "udp", "own publisher");
  ASSERT_TRUE(own) << own.error().message;
  const io::dds::TypeSupport type(new sensor_msgs::msg::ImuPubSubType);
  const auto writer = (*own)->writer("rt/imu/data_raw", type, io::reliable_writer_qos(64, false));
  ASSERT_TRUE(writer) << writer.error().message;
  Arrival out;
  for (int k = 0; k < 20; ++k) {
    auto message = imu(k);
    (*writer)->write(&message);
    EXPECT_EQ(source->next(out), SourceState::kNothing);
  }
}

}  // namespace
}  // namespace stillpoint::sources
