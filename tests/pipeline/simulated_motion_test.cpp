/// Motions that a hand does not make, through all stages: sustained acceleration, vibration, magnets.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/units.h"
#include "tests/pipeline/simulated_run.h"

namespace stillpoint::pipeline {
namespace {

constexpr char kSensor[] =
    "rate_hz: 200\n"
    "accelerometer: {noise_mps2: 0.03, bias: [0.02, -0.01, 0.03], matrix: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}\n"
    "gyroscope: {noise_radps: 0.002, bias: [0.01, -0.005, 0.008], matrix: [[1.003, 0, 0.002], [0, 0.996, 0], [0, 0, "
    "1]]}\n";

struct Errors {
  double inclination_deg = 0.0, heading_deg = 0.0, worst_inclination_deg = 0.0;
  double tilt_nees = 0.0, heading_nees = 0.0;  ///< 1 when the stated covariance is true
};

/// Rms after `from_s`.
Errors errors(const std::string& simulation, const StagesParams& params, std::uint64_t seed, double from_s) {
  Errors sum;
  int n = 0;
  test::run_simulated(simulation, params, seed, [&](const sim::SimulatedSample& truth, const Processed& out) {
    if (in_seconds(truth.sample.t_ns) < from_s) return;
    const Vec3 error = test::world_error(truth, out);
    const Mat3 covariance = mat(out.attitude.covariance_world_rad2);
    const double tilt = error.head<2>().norm() * kDegPerRad;
    sum.inclination_deg += tilt * tilt;
    sum.heading_deg += std::pow(error.z() * kDegPerRad, 2);
    sum.worst_inclination_deg = std::max(sum.worst_inclination_deg, tilt);
    sum.tilt_nees += error.head<2>().squaredNorm() / (covariance(0, 0) + covariance(1, 1));
    sum.heading_nees += error.z() * error.z() / covariance(2, 2);
    ++n;
  });
  sum.inclination_deg = std::sqrt(sum.inclination_deg / n);
  sum.heading_deg = std::sqrt(sum.heading_deg / n);
  sum.tilt_nees /= n;
  sum.heading_nees /= n;
  return sum;
}

constexpr char kMagnetometer[] =
    "magnetometer: {noise_uT: 0.4, bias: [0, 0, 0], matrix: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}\n";
constexpr char kIronOnThePhone[] =
    "magnetometer: {noise_uT: 0.4, bias: [8, -6, 10], matrix: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}\n";
constexpr char kMagnetInTheRoom[] = "environment: {iron: [{moment_Am2: [0, 0, 10], start_m: [0.6, 0, 0]}]}\n";

/// A circle at 2.5 m/s^2 for most of a minute, stops with the engine idling; the filter is set for a hand.
TEST(SimulatedMotion, CarriedIntoACarTheTiltLeansOnTheGyroscope) {
  const std::string motion = "motion: {kind: vehicle, duration_s: 600, speed_mps: 15}\n";
  for (const std::uint64_t seed : {1U, 2U}) {
    const Errors e = errors(std::string(kSensor) + kMagnetometer + motion, {}, seed, 60.0);
    EXPECT_LT(e.inclination_deg, 0.5);
    EXPECT_LT(e.worst_inclination_deg, 1.5);
    EXPECT_LT(e.heading_deg, 3.0);
    EXPECT_LT(e.tilt_nees, 1.5);
    EXPECT_LT(e.heading_nees, 1.5);
  }
}

TEST(SimulatedMotion, ADroneKeepsItsTilt) {
  const std::string motion = "motion: {kind: drone, duration_s: 300, vibration_hz: 60, vibration_mps2: 8}\n";
  for (const std::uint64_t seed : {1U, 2U}) {
    const Errors e = errors(std::string(kSensor) + kMagnetometer + motion, {}, seed, 60.0);
    EXPECT_LT(e.inclination_deg, 0.8);
    EXPECT_LT(e.tilt_nees, 3.0);
    EXPECT_LT(e.heading_deg, 3.0);
  }
}

/// A vibrating phone strapped to the sensor: iron that turns with it, in a room where a magnet bends the field.
TEST(SimulatedMotion, IronOnTheBodyIsLearntBesideAMagnetInTheRoom) {
  const std::string motion =
      "motion: {kind: hand, duration_s: 600}\n"
      "effects:\n- {effect: acc_alias, b_mps2: [3, 3, 3], f_hz: 57}\n";
  StagesParams blind;
  blind.attitude.hard_iron.sd_uT = 0.0;
  for (const char* room : {"", kMagnetInTheRoom}) {
    const std::string phone = std::string(kSensor) + kIronOnThePhone + motion + room;
    const Errors e = errors(phone, {}, 2, 300.0);
    EXPECT_LT(e.inclination_deg, 0.5);
    EXPECT_LT(e.heading_deg, 1.5);
    EXPECT_LT(e.tilt_nees, 1.5);
    EXPECT_LT(e.heading_nees, 1.5);
    EXPECT_LT(e.heading_deg, 0.5 * errors(phone, blind, 2, 300.0).heading_deg);
  }
}

/// Whatever a start in the middle of a motion has made of the tilt and the speed: a rest shows both, and nothing of the
/// contradiction may end in another state. The sensor is known, so there is nothing else to learn.
TEST(SimulatedMotion, StartedInMotionTheFirstRestSettlesTheTilt) {
  constexpr char kKnown[] =
      "rate_hz: 100\n"
      "accelerometer: {noise_mps2: 0.03}\ngyroscope: {noise_radps: 0.002}\nmagnetometer: {noise_uT: 0.4}\n"
      "motion: {kind: hand, duration_s: 60}\n";
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    const auto simulation = io::parse_simulation(kKnown, "test");
    SP_EXPECTS(simulation.has_value());
    calib::OnlineCalibrator calibrator({}, {});
    DirectLink link(calibrator);
    Stages stages({}, calibrator.snapshot());
    Processed out;
    double moved_s = 0.0, rested_s = 0.0, worst_deg = 0.0;
    for (const sim::SimulatedSample& s : sim::simulate(*simulation, seed)) {
      moved_s += s.moving ? 0.01 : 0.0;
      if (moved_s < 1.0 || stages.process(s.sample, out, link) == StageStatus::kDrop) continue;
      rested_s = out.attitude.at_rest ? rested_s + 0.01 : 0.0;
      if (rested_s > 0.5) worst_deg = std::max(worst_deg, test::world_error(s, out).head<2>().norm() * kDegPerRad);
    }
    EXPECT_LT(worst_deg, 2.0) << "seed " << seed;
  }
}

}  // namespace
}  // namespace stillpoint::pipeline
