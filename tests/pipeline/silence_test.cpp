/// Sensors that have not spoken yet, or speak no longer, while the others do.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/units.h"
#include "pipeline/sensor_loop.h"
#include "tests/pipeline/simulated_run.h"

namespace stillpoint::pipeline {
namespace {

constexpr char kNineAxes[] =
    "rate_hz: 100\n"
    "accelerometer: {noise_mps2: 0.03}\n"
    "gyroscope: {noise_radps: 0.002}\n"
    "magnetometer: {noise_uT: 0.4}\n"
    "motion: {kind: hand, duration_s: 120}\n";

/// What the stages know of the sensors after each row of simulated hand motion.
class SilenceTest : public testing::Test {
 protected:
  SilenceTest() : calibrator_({}, {}), link_(calibrator_), stages_({}, calibrator_.snapshot()) {}
  /// Up to that time; `parts` are those that speak.
  void feed_until(double t_s, int parts) {
    for (sim::SimulatedSample s; simulator_.next(s);) {
      s.sample.has = static_cast<std::uint8_t>(s.sample.has & parts);
      stages_.process(s.sample, out_, link_);
      if (in_seconds(s.sample.t_ns) >= t_s) return;
    }
  }
  /// Bits of SamplePart.
  int absent() {
    const SensorsHealth& h = stages_.health();
    int parts = 0;
    for (const auto& [part, of] : {std::pair{kAcc, &h.acc}, {kGyr, &h.gyr}, {kMag, &h.mag}, {kTemp, &h.temp}})
      parts |= of->state == Health::kAbsent ? part : 0;
    return parts;
  }

  static constexpr int kAll = kAcc | kGyr | kMag | kTemp;
  sim::SimulationConfig simulation_ = *io::parse_simulation(kNineAxes, "test");
  sim::Simulator simulator_{simulation_, sim::make_motion(*simulation_.motion, 1), 1};
  calib::OnlineCalibrator calibrator_;
  DirectLink link_;
  Stages stages_;
  Processed out_;
};

TEST_F(SilenceTest, SensorsThatHaveNotSpokenAreAbsent) {
  EXPECT_EQ(absent(), kAll);
  EXPECT_EQ(SensorReport{}.health.gyr.state, Health::kAbsent);
  feed_until(3.0, kMag);
  EXPECT_EQ(absent(), kAll & ~kMag);
  feed_until(6.0, kAll);
  EXPECT_EQ(absent(), 0);
}

TEST_F(SilenceTest, WithoutAGyroscopeNoHeadingIsLessKnownThanAny) {
  feed_until(3.0, kAll);
  feed_until(100.0, kAcc);
  EXPECT_NEAR(out_.attitude.sigma_yaw_rad, std::numbers::pi / std::sqrt(3.0), 1e-9);
  const auto eigenvalues = mat(out_.attitude.covariance_world_rad2).selfadjointView<Eigen::Lower>().eigenvalues();
  EXPECT_GT(eigenvalues.minCoeff(), 0.0);
}

TEST_F(SilenceTest, AnInertialChipThatDiesIsAbsentWhileTheMagnetometerSpeaks) {
  feed_until(10.0, kAll);
  ASSERT_EQ(absent(), 0);
  feed_until(10.5, kMag | kTemp);
  EXPECT_EQ(absent(), 0) << "a pause";
  feed_until(25.0, kMag | kTemp);
  EXPECT_EQ(absent(), kAcc | kGyr);
  EXPECT_NEAR(in_seconds(stages_.health().gyr.since_ns), 10.0, 0.1);
  EXPECT_EQ(stages_.guard().counts().late, 0U) << "the others are not late, the one that leads is silent";
  feed_until(26.0, kAll);
  EXPECT_EQ(absent(), 0);
}

TEST_F(SilenceTest, AGyroscopeThatSpeaksSeldomIsNotAbsentBetweenItsReadings) {
  for (int k = 1; k < 20; ++k) {
    feed_until(1.5 * k, kMag);
    EXPECT_TRUE(k < 3 || (absent() & kGyr) == 0) << k;
    feed_until(1.5 * k + 0.005, kAll);
  }
}

TEST_F(SilenceTest, AThermometerThatFallsSilentIsAbsentAndItsTemperatureNoLongerTold) {
  feed_until(8.0, kAll);
  EXPECT_EQ(absent(), 0);
  feed_until(16.0, kAll & ~kTemp);
  EXPECT_EQ(absent(), 0) << "it may speak seldom";
  EXPECT_TRUE(std::isfinite(to_message(out_).temp_degC));
  feed_until(20.0, kAll & ~kTemp);
  EXPECT_EQ(absent(), kTemp);
  EXPECT_TRUE(std::isnan(to_message(out_).temp_degC));
  EXPECT_NE(stages_.health().worst(), Health::kAbsent) << "the attitude does not stand on it";
  feed_until(21.0, kAll);
  EXPECT_EQ(absent(), 0);
}

}  // namespace
}  // namespace stillpoint::pipeline
