/// What lies still can be judged to the noise of the sensor: a lattice beneath it, an offset that wanders, a vibration
/// that no camera sees. None of them may pass for a simulation that explains the recording.
#include <gmock/gmock.h>

#include <cmath>
#include <numbers>
#include <random>

#include "core/so3.h"
#include "diagnosis/summary.h"
#include "tests/diagnosis/simulated.h"

namespace stillpoint::diag {
namespace {

using testing::Contains;
using testing::Each;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::SizeIs;

/// A minute on a bench, beside a camera whose orientation has noise of 0.3 mrad.
io::Recording on_a_bench(const sim::SimulationConfig& config, std::uint64_t seed) {
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> normal;
  const auto noise = [&](double sd) { return Vec3(sd * normal(engine), sd * normal(engine), sd * normal(engine)); };
  const Quat still = exp_quat(Vec3(0.2, -0.1, 0.4));
  io::Recording r;
  for (int i = 0; i < 3000; ++i) {
    const Quat seen = still * exp_quat(noise(3e-4));
    r.t_ns.push_back(20'000'000LL * i);
    r.ref_q_world_body.emplace_back(seen.w(), seen.x(), seen.y(), seen.z());
    r.ref_position_m.push_back(noise(5e-5));
    r.acc_mps2.push_back(still.conjugate() * Vec3(0, 0, config.gravity_mps2) + noise(0.02));
    r.gyr_radps.push_back(config.gyroscope->bias + noise(config.gyroscope->noise_sd));
    r.mag_uT.push_back(still.conjugate() * config.field_world_uT + config.magnetometer->bias + noise(0.3));
  }
  return r;
}

const ChannelResidual& channel(const Diagnosis& d, const std::string& name) {
  for (const auto& c : d.residual)
    if (c.channel == name) return c;
  static const ChannelResidual kNone{};
  return kNone;
}

TEST(LeftAtRest, ALatticeUnderItsNoiseHidesNothing) {
  const auto config = test::baseline("mocap");
  auto r = on_a_bench(config, 5);
  constexpr double kStep = 0.0021031;  // of noise 0.001
  for (Vec3& w : r.gyr_radps) w = ((w + Vec3(0.0052, 0, 0)) / kStep).array().round() * kStep;
  const auto d = diagnose(r, config).diagnosis;
  EXPECT_THAT(test::names(d), Contains("gyr_quant"));
  EXPECT_NEAR(channel(d, "gyr_x").rms_after, std::hypot(0.001, kStep / std::sqrt(12.0)), 1e-4);
  ASSERT_THAT(d.configuration, SizeIs(1)) << d.summary;
  EXPECT_EQ(d.configuration[0].sensor, "gyr");
  EXPECT_THAT(d.configuration[0].what, HasSubstr("(0.0052"));
  EXPECT_THAT(to_text(d), Not(HasSubstr("e+")));
}

TEST(LeftAtRest, ALatticeOverItsNoiseIsSaidToHideTheSensor) {
  const auto config = test::baseline("mocap");
  auto r = on_a_bench(config, 6);
  constexpr double kStep = 0.0040213;
  for (Vec3& w : r.gyr_radps) w = (w / kStep).array().round() * kStep;
  const auto d = diagnose(r, config).diagnosis;
  EXPECT_EQ(channel(d, "gyr_x").channel, "") << "nothing of it was tested";
  EXPECT_THAT(d.notices, Contains(HasSubstr("gyr: at rest its steps of 0.00402 rad/s hide")));
}

TEST(LeftAtRest, AnOffsetThatWandersWakesNoBodyAndIsNotExplained) {
  const auto config = test::baseline("mocap");
  auto r = on_a_bench(config, 7);
  for (std::size_t i = 0; i < r.size(); ++i) {
    const double t = r.t_s(i);
    r.gyr_radps[i].x() += 0.3 * std::exp(-0.5 * std::pow((t - 20) / 1.5, 2)) - 0.2 * std::sin(0.9 * t) * (t > 35);
  }
  const Answer answer = diagnose(r, config);
  EXPECT_THAT(test::names(answer), Each(HasSubstr("unknown"))) << answer.diagnosis.summary;
  EXPECT_EQ(answer.diagnosis.verdict, Verdict::kUnexplained);
  for (const Finding& f : answer.diagnosis.findings) EXPECT_THAT(f.channels, Each(HasSubstr("gyr")));
}

TEST(LeftAtRest, AVibrationThatTheCameraCannotSeeIsNoNoise) {
  const auto config = test::baseline("mocap", 60.0);
  io::Recording r = test::record(config, "", {}, 12);
  const auto quiet = diagnose(r, config).diagnosis;
  EXPECT_EQ(quiet.verdict, Verdict::kNoMismatch) << quiet.summary;
  EXPECT_THAT(quiet.unaccounted, IsEmpty());
  double angle = 0.0;
  for (std::size_t i = 0; i < r.size(); ++i) {
    angle += 2.0 * std::numbers::pi * 0.02 * (9.0 + 3.0 * std::sin(0.2 * r.t_s(i)));
    r.acc_mps2[i] += Vec3(0.3, 0.1, 0.2) * std::sin(angle);
  }
  const auto d = diagnose(r, config).diagnosis;
  EXPECT_EQ(d.verdict, Verdict::kUnexplained) << d.summary;
  ASSERT_THAT(d.unaccounted, SizeIs(1)) << d.summary;
  EXPECT_THAT(d.unaccounted[0], HasSubstr("acc at rest swings at"));
  EXPECT_THAT(d.noise, IsEmpty()) << "it is none";
}

}  // namespace
}  // namespace stillpoint::diag
