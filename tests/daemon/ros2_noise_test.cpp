/// The noise that a ROS 2 driver states of its readings, from its messages to the deviation of the published attitude.
#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <thread>

#include "io/dds_subscriber.h"
#include "tests/apps/apps_testing.h"

namespace stillpoint {
namespace {

class Ros2Noise : public testing::Test {
 protected:
  /// By how much the heading's variance grows in 50 attitudes, the least of 300, as a deviation; 0: they did not come.
  /// The least: a row that comes late on a busy machine adds a doubt of its own.
  double sigma_yaw(const std::string& variance, const std::string& source_keys) {
    constexpr int kAttitudes = 600, kFirst = 300, kStretch = 50;  // at first a magnetometer may yet come
    io::DdsParams dds;
    dds.domain = io::own_domain();
    // A gyroscope without errors but its white noise, and nothing that knows the heading.
    test::write_file(folder_ / "d.yaml", "source: {kind: ros2, mag_topic: '', reliable: true" + source_keys +
                                             "}\nattitude: {gyr_noise_radps_rtHz: 2e-4, gyr_rate_noise_rtHz: 0, "
                                             "gyr_bias_sd_radps: 0, gyr_bias_walk_radps_rtHz: 0, gyr_matrix_sd: 0}\n"
                                             "dds: {domain: " +
                                             std::to_string(dds.domain) + "}\n");
    std::array<double, kAttitudes> variance_rad2{};
    std::atomic<int> received{0};
    const auto subscriber = io::DdsSubscriber::create(dds, {.attitude = [&](const AttitudeMessage& m, std::int64_t) {
                                                        const auto at = static_cast<std::size_t>(received.load());
                                                        if (at == kAttitudes) return;
                                                        variance_rad2[at] = m.sigma_rpy_rad[2] * m.sigma_rpy_rad[2];
                                                        ++received;
                                                      }});
    EXPECT_TRUE(subscriber);
    test::Process daemon({STILLPOINTD, "--config", folder_ / "d.yaml"}, folder_ / "log");
    const test::Process driver({ROS2_DRIVER, std::to_string(dds.domain), "6000", "200", "", variance});
    for (int k = 0; k < 300 && received < kAttitudes; ++k) std::this_thread::sleep_for(std::chrono::milliseconds(100));
    daemon.send(SIGTERM);
    daemon.wait();
    if (received < kAttitudes) return 0.0;
    double least_rad2 = 1e9;
    for (std::size_t k = kFirst + kStretch; k < kAttitudes; ++k)
      least_rad2 = std::min(least_rad2, variance_rad2[k] - variance_rad2[k - kStretch]);
    return std::sqrt(std::max(0.0, least_rad2));
  }
  [[nodiscard]] std::string log() const { return test::read_file(folder_ / "log"); }
  test::ScratchFolder folder_;
};

// At 200 Hz the configured density is a variance of 8e-6 a reading.
TEST_F(Ros2Noise, AHundredTimesTheConfiguredVarianceMakesTheAttitudeTenTimesAsUnsure) {
  const double configured = sigma_yaw("0", "");
  ASSERT_GT(configured, 0.0) << log();
  const double stated = sigma_yaw("8e-4", "");
  EXPECT_THAT(log(), testing::HasSubstr("it states its noise, 0 m/s^2, 0.0283 rad/s, 0 uT"));
  EXPECT_GT(stated, 5.0 * configured);
  EXPECT_LT(stated, 20.0 * configured);
}

TEST_F(Ros2Noise, IsIgnoredWhereTheConfigurationSaysSo) {
  const double configured = sigma_yaw("0", "");
  ASSERT_GT(configured, 0.0) << log();
  const double ignored = sigma_yaw("8e-4", ", use_covariance: false");
  EXPECT_GT(ignored, 0.0) << log();
  EXPECT_LT(ignored, 2.0 * configured);
}

TEST_F(Ros2Noise, ThatNoSensorHasIsNamedAndRefused) {
  const double refused = sigma_yaw("-0.5", "");
  EXPECT_GT(refused, 0.0) << log();
  EXPECT_LT(refused, 0.01) << "the attitude goes on with what is configured";
  EXPECT_THAT(log(), testing::HasSubstr("of the gyroscope: a variance of -0.5 is negative; what is configured serves"));
}

}  // namespace
}  // namespace stillpoint
