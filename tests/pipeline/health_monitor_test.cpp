/// Faults that a user makes or a sensor gets, through all stages over simulated hand motion: named, and never `ok`.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "core/so3.h"
#include "core/units.h"
#include "tests/pipeline/simulated_run.h"

namespace stillpoint::pipeline {
namespace {

constexpr char kHand[] =
    "rate_hz: 100\n"
    "accelerometer: {noise_mps2: 0.03, bias: [0, 0, 0], matrix: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}\n"
    "gyroscope: {noise_radps: 0.002, bias: [0.01, -0.02, 0.01], matrix: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}\n"
    "magnetometer: {noise_uT: 0.4, bias: [5, 3, -4], matrix: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}\n"
    "motion: {kind: hand, duration_s: 120}\n";
constexpr double kFrom_s = 20.0;

struct Outcome {
  Fault acc = Fault::kNone, gyr = Fault::kNone, mag = Fault::kNone, temp = Fault::kNone;  ///< at the end
  bool ever_faulty = false, ever_noisy = false;
  double named_s = INFINITY;  ///< from the start of the fault
  int ok_outside = 0;         ///< samples in the last 40 s
};

Outcome run(const std::function<void(RawSample&)>& spoil, std::uint64_t seed) {
  const auto simulation = io::parse_simulation(kHand, "test");
  SP_EXPECTS(simulation.has_value());
  sim::Simulator simulator(*simulation, sim::make_motion(*simulation->motion, seed), seed);
  calib::OnlineCalibrator calibrator({}, {});
  DirectLink link(calibrator);
  Stages stages({}, calibrator.snapshot());
  Processed out;
  Outcome outcome;
  for (sim::SimulatedSample s; simulator.next(s);) {
    const double t_s = in_seconds(s.sample.t_ns);
    if (t_s > kFrom_s) spoil(s.sample);
    if (stages.process(s.sample, out, link) == StageStatus::kDrop) continue;
    for (const SensorHealth& sensor : {out.health.acc, out.health.gyr, out.health.mag})
      outcome.ever_faulty |= sensor.state == Health::kFaulty, outcome.ever_noisy |= sensor.fault == Fault::kNoisy;
    if (outcome.ever_faulty) outcome.named_s = std::min(outcome.named_s, t_s - kFrom_s);
    const Vec3 error = test::world_error(s, out);
    const bool outside = error.head<2>().norm() > 3.0 * (out.attitude.sigma_roll_rad + out.attitude.sigma_pitch_rad);
    outcome.ok_outside += t_s > 80.0 && outside && to_message(out).status == AttitudeStatus::kOk;
  }
  outcome.acc = out.health.acc.fault;
  outcome.gyr = out.health.gyr.fault;
  outcome.mag = out.health.mag.fault;
  outcome.temp = out.health.temp.fault;
  return outcome;
}

TEST(HealthMonitor, NamesNothingInSoundStreams) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Outcome sound = run([](RawSample&) {}, seed);
    EXPECT_FALSE(sound.ever_faulty || sound.ever_noisy) << seed;
  }
}

TEST(HealthMonitor, NamesAGyroscopeWithMirroredOrSwappedAxes) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const Outcome mirrored = run([](RawSample& s) { s.gyr_radps[0] *= -1.0; }, seed);
    EXPECT_EQ(mirrored.gyr, Fault::kAxes) << seed;
    EXPECT_EQ(mirrored.ok_outside, 0) << seed;
    const Outcome swapped = run([](RawSample& s) { std::swap(s.gyr_radps[0], s.gyr_radps[1]); }, seed);
    EXPECT_TRUE(swapped.gyr == Fault::kAxes || swapped.gyr == Fault::kInconsistent) << seed;
    EXPECT_EQ(swapped.ok_outside, 0) << seed;
  }
}

/// On an arm that swings the force stands still in the body while the body turns by a radian and back.
TEST(HealthMonitor, NamesNothingOnAnArmThatSwings) {
  calib::OnlineCalibrator calibrator({}, {});
  DirectLink link(calibrator);
  Stages stages({}, calibrator.snapshot());
  Processed out;
  constexpr double kArm_m = 0.36, kWide_rad = 0.45, kOmega = 2.0 * std::numbers::pi / 1.23;
  std::mt19937_64 engine(3);
  std::normal_distribution<double> noise(0.0, 0.02);
  bool faulty = false, moved = false;
  for (int i = 0; i < 6000; ++i) {
    const double t = 0.01 * i, phase = kOmega * std::max(0.0, t - 5.0);
    const double angle = kWide_rad * std::sin(phase), rate = phase > 0 ? kWide_rad * kOmega * std::cos(phase) : 0.0;
    const double tangential = -kArm_m * kOmega * kOmega * angle * (phase > 0);
    RawSample s;
    s.t_ns = 10'000'000LL * (i + 1);
    s.has = kAcc | kGyr;
    s.acc_mps2 = {tangential + kStandardGravity_mps2 * std::sin(angle) + noise(engine), noise(engine),
                  kStandardGravity_mps2 * std::cos(angle) + kArm_m * rate * rate + noise(engine)};
    s.gyr_radps = {0.05 * noise(engine), -rate + 0.05 * noise(engine), 0.05 * noise(engine)};
    if (stages.process(s, out, link) == StageStatus::kDrop) continue;
    faulty |= out.health.acc.state == Health::kFaulty || out.health.gyr.state == Health::kFaulty;
    moved |= std::abs(angle) > 0.4;
  }
  EXPECT_TRUE(moved);
  EXPECT_FALSE(faulty);
}

/// Strokes that accelerate the body by as much as gravity while it turns: the force passes the length of gravity now
/// and then, and points elsewhere.
TEST(HealthMonitor, NamesNothingInViolentMotion) {
  calib::OnlineCalibrator calibrator({}, {});
  DirectLink link(calibrator);
  Stages stages({}, calibrator.snapshot());
  Processed out;
  Quat q = Quat::Identity();
  bool faulty = false;
  for (int i = 0; i < 9000; ++i) {
    const double t = 0.01 * i, begun = t > 5.0 ? t - 5.0 : 0.0;
    const auto wave = [begun](double hz, double phase) {
      return begun > 0.0 ? std::sin(2.0 * std::numbers::pi * hz * begun + phase) : 0.0;
    };
    const Vec3 rate(3.0 * wave(0.9, 0.0), 2.5 * wave(0.7, 1.0), 2.0 * wave(0.4, 2.0));
    const Vec3 acceleration(8.0 * wave(1.1, 0.5), 7.0 * wave(1.3, 2.5), 6.0 * wave(1.7, 1.5));
    RawSample s;
    s.t_ns = 10'000'000LL * (i + 1);
    s.has = kAcc | kGyr;
    s.gyr_radps = array(rate);
    q = (q * exp_quat(Vec3(0.01 * rate))).normalized();
    s.acc_mps2 = array(Vec3(q.conjugate() * (acceleration + Vec3(0.0, 0.0, kStandardGravity_mps2))));
    s.acc_mps2[0] += 1e-3 * std::sin(0.37 * i), s.gyr_radps[0] += 1e-4 * std::cos(0.53 * i);
    if (stages.process(s, out, link) == StageStatus::kDrop) continue;
    faulty |= out.health.gyr.state == Health::kFaulty;
  }
  EXPECT_FALSE(faulty);
}

TEST(HealthMonitor, NamesReadingsThatRepeatOrComeInAnotherUnit) {
  EXPECT_EQ(run([](RawSample& s) { s.gyr_radps = {0.1, 0.2, 0.3}; }, 1).gyr, Fault::kStuck);
  EXPECT_EQ(run([](RawSample& s) { s.acc_mps2 = {0.0, 0.0, 0.0}; }, 1).acc, Fault::kZero);
  EXPECT_EQ(run([](RawSample& s) { s.mag_uT = {20.0, 5.0, -40.0}; }, 1).mag, Fault::kStuck);
  const Outcome in_g = run([](RawSample& s) { vec(s.acc_mps2) /= kStandardGravity_mps2; }, 1);
  EXPECT_EQ(in_g.acc, Fault::kUnits);
  EXPECT_EQ(in_g.ok_outside, 0);
}

/// A hand that turns the sensor this way and that for half a minute and lays it down; deg/s given as rad/s.
TEST(HealthMonitor, SaysNeverOkWhileAUnitIsKnownToBeWrong) {
  calib::OnlineCalibrator calibrator({}, {});
  DirectLink link(calibrator);
  Stages stages({}, calibrator.snapshot());
  Processed out;
  std::mt19937_64 engine(1);
  std::normal_distribution<double> normal;
  const auto noise = [&] { return Vec3(normal(engine), normal(engine), normal(engine)); };
  Quat attitude = Quat::Identity();
  int found = 0, ok = 0;
  for (int k = 1; k < 9000; ++k) {
    const double t = 0.01 * k;
    const bool moves = (t > 5.0 && t < 35.0) || (t > 60.0 && t < 80.0);
    const Vec3 rate =
        moves ? Vec3(0.9 * std::sin(1.1 * t), 0.5 * std::sin(0.7 * t), 0.3 * std::cos(0.5 * t)) : Vec3::Zero();
    attitude = attitude * exp_quat(0.01 * rate);
    RawSample s;
    s.t_ns = 10'000'000LL * k;
    s.has = kAcc | kGyr;
    s.acc_mps2 = array(Vec3(attitude.conjugate() * Vec3(0, 0, kStandardGravity_mps2) + 0.03 * noise()));
    s.gyr_radps = array(Vec3(kDegPerRad * (rate + Vec3(0.002, -0.001, 0.003) + 0.0005 * noise())));
    if (stages.process(s, out, link) == StageStatus::kDrop || stages.findings().empty()) continue;
    ++found;
    ok += to_message(out).status == AttitudeStatus::kOk ? 1 : 0;
  }
  EXPECT_GT(found, 7000) << "within fifteen seconds of use";
  EXPECT_EQ(ok, 0);
  EXPECT_EQ(out.health.gyr.fault, Fault::kUnits) << "at rest as well";
}

TEST(HealthMonitor, BelievesAGyroscopeAgainThatIsBackInItsUnit) {
  const Outcome back = run(
      [k = 0](RawSample& s) mutable {
        if (++k < 3000) s.gyr_radps = array(Vec3(kDegPerRad * vec(s.gyr_radps)));
      },
      2);
  EXPECT_TRUE(back.ever_faulty);
  EXPECT_EQ(back.gyr, Fault::kNone);
}

TEST(HealthMonitor, NamesAnAccelerometerOrAGyroscopeThatHasBecomeNoisy) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    std::mt19937 random(static_cast<unsigned>(seed));
    std::normal_distribution<double> normal;
    const auto noisy = [&](Array3 RawSample::*triad, double sd) {
      return run(
          [&, triad, sd](RawSample& s) {
            for (double& x : s.*triad) x += sd * normal(random);
          },
          seed);
    };
    EXPECT_TRUE(noisy(&RawSample::acc_mps2, 0.9).ever_noisy) << seed;
    EXPECT_TRUE(noisy(&RawSample::gyr_radps, 0.06).ever_noisy) << seed;
  }
}

TEST(HealthMonitor, NamesAThermometerInKelvin) {
  EXPECT_EQ(run(
                [](RawSample& s) {
                  s.temp_degC = 295.0 + 1e-10 * static_cast<double>(s.t_ns % 100'000'000'000), s.has |= kTemp;
                },
                1)
                .temp,
            Fault::kUnits);
}

TEST(HealthMonitor, NamesOneAxisThatSticksAndTheFilterLivesWithoutThatSensor) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const Outcome acc = run([](RawSample& s) { s.acc_mps2[1] = 0.4; }, seed);
    EXPECT_EQ(acc.acc, Fault::kStuck) << seed;
    EXPECT_EQ(acc.ok_outside, 0) << seed;
    const Outcome mag = run([](RawSample& s) { s.mag_uT[2] = -21.5; }, seed);
    EXPECT_EQ(mag.mag, Fault::kStuck) << seed;
    EXPECT_LT(mag.named_s, 6.0) << seed;  // the body rests at first
  }
}

TEST(HealthMonitor, NamesAnAccelerometerThatReadsTwiceTheForceAndTheFilterLivesWithoutIt) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Outcome twice = run([](RawSample& s) { vec(s.acc_mps2) *= 2.0; }, seed);
    EXPECT_EQ(twice.acc, Fault::kScale) << seed;
    EXPECT_LT(twice.named_s, 3.0) << seed;
    EXPECT_EQ(twice.ok_outside, 0) << seed;
  }
}

TEST(HealthMonitor, AForceThatJumpsElsewhereWithoutATurnIsSeenAtOnce) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed)
    EXPECT_LT(run([](RawSample& s) { vec(s.acc_mps2) *= -1.0; }, seed).named_s, 3.0) << seed;
}

TEST(HealthMonitor, NamesABusThatHangs) {
  const RawSample* hung = nullptr;
  RawSample last;
  const Outcome o = run(
      [&](RawSample& s) {
        if (hung == nullptr) last = s;
        hung = &last;
        s.acc_mps2 = last.acc_mps2;
        s.gyr_radps = last.gyr_radps;
        s.mag_uT = last.mag_uT;
      },
      1);
  EXPECT_EQ(o.acc, Fault::kStuck);
  EXPECT_EQ(o.gyr, Fault::kStuck);
  EXPECT_EQ(o.ok_outside, 0);
}

TEST(HealthMonitor, NamesSpikesAndNothingIsLostByThem) {
  int row = 0;
  const Outcome o = run([&](RawSample& s) { s.gyr_radps[2] = ++row % 100 == 0 ? 300.0 : s.gyr_radps[2]; }, 1);
  EXPECT_EQ(o.gyr, Fault::kSpikes);
  EXPECT_FALSE(o.ever_faulty);
  EXPECT_EQ(o.ok_outside, 0);
}

}  // namespace
}  // namespace stillpoint::pipeline
