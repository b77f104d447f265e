/// What is wrong with a camera is told as its set-up and allowed for, and is no physics of a sensor.
#include <gmock/gmock.h>

#include "tests/diagnosis/simulated.h"

namespace stillpoint::diag {
namespace {

using testing::Contains;
using testing::Field;
using testing::HasSubstr;
using testing::IsEmpty;

/// A lively hand beside a camera.
sim::SimulationConfig beside_a_camera(const std::string& effects = "[]", double rate_hz = 50.0) {
  return test::parsed(
      "rate_hz: " + std::to_string(rate_hz) +
      "\naccelerometer: {noise_mps2: 0.01}\ngyroscope: {noise_radps: 0.0005}\n"
      "magnetometer: {noise_uT: 0.3}\nmotion: {kind: hand, duration_s: 90}\n"
      "reference: {kind: mocap, orientation_sd_rad: 0.0003, position_sd_m: 0.00005, band_hz: 5}\neffects: " +
      effects + "\n");
}

io::Recording recorded(std::uint64_t seed, const std::string& effects = "[]", double rate_hz = 50.0) {
  return io::to_recording(sim::simulate(beside_a_camera(effects, rate_hz), seed));
}

/// Frames as fast as the rows that fall half between them: each row's pose is the middle of a line that bends nowhere.
io::Recording drawn_between_frames(std::uint64_t seed) {
  const io::Recording fine = recorded(seed, "[]", 100.0);
  io::Recording out;
  for (std::size_t i = 1; i + 1 < fine.size(); i += 2) {
    const Eigen::Vector4d &q = fine.ref_q_world_body[i - 1], &next = fine.ref_q_world_body[i + 1];
    out.t_ns.push_back(fine.t_ns[i]);
    out.acc_mps2.push_back(fine.acc_mps2[i]);
    out.gyr_radps.push_back(fine.gyr_radps[i]);
    out.mag_uT.push_back(fine.mag_uT[i]);
    out.ref_q_world_body.push_back((q + next * (q.dot(next) < 0 ? -1.0 : 1.0)).normalized());
    out.ref_position_m.push_back(0.5 * (fine.ref_position_m[i - 1] + fine.ref_position_m[i + 1]));
  }
  return out;
}

TEST(ReferenceSetUp, FramesDrawnOntoRowsOfTheSameRateAreNoPhysics) {
  for (const std::uint64_t seed : {1, 2}) {
    const Answer answer = diagnose(drawn_between_frames(seed), beside_a_camera());
    EXPECT_THAT(test::names(answer), IsEmpty()) << "seed " << seed;
    EXPECT_THAT(answer.diagnosis.notices, Contains(HasSubstr("smoothed, or drawn as lines"))) << "seed " << seed;
  }
}

TEST(ReferenceSetUp, AttitudesInAnotherWorldThanThePositionsAreToldSo) {
  for (const bool leans : {false, true}) {
    io::Recording r = recorded(3);
    test::turn_reference(
        r, [&](double) { return leans ? Vec3(0.004, -0.003, 0.0) : Vec3(0.0, 0.0, 0.006); }, true);
    const Answer answer = diagnose(r, beside_a_camera());
    EXPECT_THAT(test::names(answer), IsEmpty());
    EXPECT_THAT(answer.diagnosis.configuration,
                Contains(Field(&ConfigurationFault::what, HasSubstr("turned against that of its positions"))));
  }
}

TEST(ReferenceSetUp, ALowPassOfTheSensorIsNotTakenForIt) {
  const Answer answer = diagnose(recorded(4, "[{effect: gyr_lpf, tau_s: 0.008}]"), beside_a_camera());
  EXPECT_NE(test::finding(answer, "gyr_lpf"), nullptr) << answer.diagnosis.summary;
}

}  // namespace
}  // namespace stillpoint::diag
