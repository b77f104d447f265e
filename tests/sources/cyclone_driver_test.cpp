/// A driver that is not Fast DDS: Cyclone DDS with its own settings, as a ROS 2 driver under rmw_cyclonedds has them,
/// in a network where it listens on every interface.
#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <thread>

#include "sources/ros2_source.h"
#include "tests/dds/network_namespace.h"
#include "tests/dds/process.h"
#include "tests/sources/sources_testing.h"

namespace stillpoint::sources {
namespace {

using pipeline::Arrival;
using pipeline::SourceState;

struct Meeting {
  const char* name;
  bool reliable, driver_first;
};

class CycloneDriver : public testing::TestWithParam<Meeting> {};

TEST_P(CycloneDriver, IsHeardToTheLastMessage) {
  if (std::string(CYCLONE_DRIVER).empty())
    GTEST_SKIP() << "LOUD: SKIPPED: no Cyclone DDS was found when this was configured (apt-get install cyclonedds-dev "
                    "cyclonedds-tools)";
  const test::NetworkNamespace network;
  if (!network.ready())
    GTEST_SKIP() << "LOUD: SKIPPED: no network namespace of one's own here (root and `ip` of iproute2 are needed)";
  constexpr int kSamples = 1000;
  const std::vector<std::string> command{"/usr/bin/env",           "CYCLONEDDS_URI=<Domain/>",
                                         CYCLONE_DRIVER,           GetParam().reliable ? "reliable" : "best_effort",
                                         std::to_string(kSamples), "200"};
  io::Ros2Params params;
  params.reliable = GetParam().reliable;
  params.domain = 0;
  std::optional<test::Process> driver;
  if (GetParam().driver_first) {
    driver.emplace(command);
    std::this_thread::sleep_for(std::chrono::milliseconds(2500));  // past its first announcements
  }
  auto source = Ros2Source::create(params, {});
  ASSERT_TRUE(source) << source.error().message;
  if (!driver) {
    std::this_thread::sleep_for(std::chrono::milliseconds(2500));
    driver.emplace(command);
  }
  int imu = 0, mag = 0, last = -1;
  Arrival out;
  ASSERT_TRUE(test::eventually_sample(*source, out, 30.0)) << "driver ended with " << driver->wait();
  do {
    if (out.sample.holds(kMag)) {
      ++mag;
      EXPECT_NEAR(out.sample.mag_uT[2], -43.0, 1e-9);
    } else {
      ++imu;
      EXPECT_EQ(out.sample.acc_mps2[2], 9.8);
      EXPECT_GT(out.sample.gyr_radps[0], last) << "in order";
      last = static_cast<int>(out.sample.gyr_radps[0]);
    }
  } while (last < kSamples - 1 && test::eventually_sample(*source, out));
  while (mag < kSamples / 5 && test::eventually_sample(*source, out, 2.0)) mag += out.sample.holds(kMag) ? 1 : 0;
  EXPECT_EQ(driver->wait(), 0);
  const double least = GetParam().reliable ? 1.0 : 0.95;  // of best effort some may be lost where the machine is busy
  EXPECT_GE(imu, least * kSamples);
  EXPECT_GE(mag, least * kSamples / 5);
  EXPECT_EQ(source->report()->try_load()->malformed, 0U);
  EXPECT_TRUE(test::eventually_state(*source, out, SourceState::kGone, 15.0));
}

INSTANTIATE_TEST_SUITE_P(Matrix, CycloneDriver,
                         testing::Values(Meeting{"ReliableFirst", true, true}, Meeting{"ReliableAfter", true, false},
                                         Meeting{"BestEffortFirst", false, true},
                                         Meeting{"BestEffortAfter", false, false}),
                         [](const auto& meeting) { return meeting.param.name; });

}  // namespace
}  // namespace stillpoint::sources
