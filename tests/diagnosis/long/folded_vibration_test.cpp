/// A body that vibrates faster than half the rate of the rows: the reference is right in every row, its derivative is
/// not, and neither is physics of a sensor.
#include <gmock/gmock.h>

#include "tests/diagnosis/simulated.h"

namespace stillpoint::diag {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

/// Rotors at 120 Hz shake and rock it.
sim::SimulationConfig drone(double rate_hz, double shake_mps2, const std::string& reference = "exact") {
  sim::SimulationConfig config = test::baseline(reference, 40.0);
  config.rate_hz = rate_hz;
  config.motion->kind = "drone";
  config.motion->vibration_mps2 = shake_mps2;
  return config;
}

TEST(FoldedVibration, IsPredictedWithItsOwnFrequency) {
  const auto config = drone(100.0, 0.0);
  for (const std::uint64_t seed : {1, 2}) {
    const Answer answer = diagnose(test::record(config, "", {}, seed), config);
    EXPECT_THAT(test::names(answer), IsEmpty()) << seed;
    EXPECT_THAT(answer.diagnosis.notices,
                Contains(HasSubstr("the body vibrates at 120 Hz, which 100 rows a second fold to 20 Hz")));
  }
}

/// An engine of 24 Hz: the differences of 50 rows a second see four fifths of its acceleration.
TEST(FoldedVibration, NearHalfTheRateIsPredictedWithWhatTheDifferencesMiss) {
  auto config = test::baseline("exact", 60.0);
  config.motion->kind = "vehicle";
  for (const std::uint64_t seed : {5, 6}) {
    const Answer answer = diagnose(test::record(config, "", {}, seed), config);
    EXPECT_THAT(test::names(answer), IsEmpty()) << seed;
    EXPECT_THAT(answer.diagnosis.notices, Contains(HasSubstr("vibrates at 24 Hz, which 50 rows a second hardly")));
  }
}

TEST(FoldedVibration, HidesNoPhysicsBesideIt) {
  const auto config = drone(100.0, 0.0);
  const test::Parameters gsens{{"G_radps_per_mps2", {2e-3, 0, 0, 0, -2e-3, 0, 0, 0, 1e-3}}};
  EXPECT_THAT(test::names(diagnose(test::record(config, "gyr_gsens", gsens, 3), config)), ElementsAre("gyr_gsens"));
}

/// A sensor's own line is no multiple of what the reference shows.
TEST(FoldedVibration, IsNotALineOfTheSensor) {
  const auto config = drone(100.0, 0.0);
  const test::Parameters line{{"b_radps", {0.01, -0.02, 0.01}}, {"f_hz", {31.7}}};
  EXPECT_THAT(test::names(diagnose(test::record(config, "gyr_alias", line, 3), config)), ElementsAre("gyr_alias"));
}

/// Near half the rate of the rows no derivative is right, and between them it only seems to be.
TEST(FoldedVibration, NearHalfTheRateKeepsItsSensorOut) {
  for (const double shake_mps2 : {0.0, 6.0}) {
    const auto config = drone(200.0, shake_mps2);
    for (const std::uint64_t seed : {33, 37}) {
      const Answer answer = diagnose(test::record(config, "", {}, seed), config);
      EXPECT_THAT(test::names(answer), IsEmpty()) << shake_mps2 << " " << seed;
      EXPECT_THAT(answer.diagnosis.notices, Contains(HasSubstr("the body vibrates too fast for a reference")));
    }
  }
}

TEST(FoldedVibration, ThatACameraDoesNotSeeIsNoLineOfASensor) {
  auto config = drone(100.0, 0.0, "mocap");
  config.accelerometer->noise_sd = 0.005;  // it feels gravity rock by 2 mm/s^2
  for (const std::uint64_t seed : {1, 2}) {
    const Answer answer = diagnose(test::record(config, "", {}, seed), config);
    EXPECT_THAT(test::names(answer), Not(Contains(HasSubstr("gyr_")))) << seed;
    EXPECT_THAT(answer.diagnosis.notices, Contains(HasSubstr("gyr: swings at 20 Hz, and so does another sensor")));
  }
}

/// Where no other sensor is good enough to feel it, it swells and fades with the rotors.
TEST(FoldedVibration, ThatNothingElseFeelsIsToldByItsSwelling) {
  const auto config = drone(100.0, 0.0, "mocap");
  for (const std::uint64_t seed : {1, 2, 3}) {
    const Answer answer = diagnose(test::record(config, "", {}, seed), config);
    EXPECT_THAT(test::names(answer), IsEmpty()) << seed;
    EXPECT_THAT(answer.diagnosis.notices, Contains(HasSubstr("gyr: swings at 20 Hz, more and less"))) << seed;
  }
}

}  // namespace
}  // namespace stillpoint::diag
