/// Faults of raw values on a plain synthetic hand motion, and on the recordings where what is there is known.
#include "diagnosis/forensics/forensics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <functional>
#include <random>

#include "tests/diagnosis/simulated.h"
#include "tests/source_folder.h"

namespace stillpoint::diag {
namespace {

constexpr std::size_t kRows = 6000;
constexpr double kRate_hz = 50.0;

double printed(double v, double decimals) {
  const double scale = std::pow(10.0, decimals);
  return std::round(v * scale) / scale;
}

/// Rest of 3 s and motion of 7 s in turn, written with the decimals of the recordings' files. `raw` may spoil a reading
/// (sensor, axis, row, value) before it is written.
using Spoil = std::function<double(Sensor, int, std::size_t, double)>;
io::Recording hand_motion(
    unsigned seed, const Spoil& raw = [](Sensor, int, std::size_t, double v) { return v; }) {
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> normal;
  io::Recording r;
  for (std::size_t i = 0; i < kRows; ++i) {
    const double t = static_cast<double>(i) / kRate_hz;
    const double in_bout = std::fmod(t, 10.0) - 3.0;
    const double w = in_bout < 0 ? 0.0 : std::sin(M_PI * in_bout / 7.0);
    Vec3 acc, gyr, mag;
    for (int k = 0; k < 3; ++k) {
      const double swing = w * std::sin(2.0 * M_PI * (0.7 + 0.3 * k) * t + k);
      acc[k] = printed(raw(kAcc, k, i, 0.1 + (k == 2 ? 9.81 : 0.0) + 9.0 * swing + 0.02 * normal(engine)), 6);
      gyr[k] = printed(raw(kGyr, k, i, 4.0 * swing + 0.001 * normal(engine)), 7);
      mag[k] = printed(raw(kMag, k, i, 20.0 - 15.0 * k + 12.0 * swing + 0.3 * normal(engine)), 5);
    }
    r.t_ns.push_back(static_cast<std::int64_t>(std::llround(1e9 * t)));
    r.acc_mps2.push_back(acc), r.gyr_radps.push_back(gyr), r.mag_uT.push_back(mag);
  }
  return r;
}

std::vector<std::string> names(const Forensics& f) {
  std::vector<std::string> n;
  for (const auto& x : f.findings) n.push_back(x.effect);
  return n;
}
using Names = std::vector<std::string>;

bool covers(const Parameter& p, double truth) { return p.ci95[0] <= truth && truth <= p.ci95[1]; }

TEST(Forensics, SaysNothingOfCleanRecordings) {
  for (unsigned seed = 0; seed < 20; ++seed)
    EXPECT_EQ(names(examine_raw_values(hand_motion(seed), test::sensors())), Names{});
}

TEST(Forensics, DoesNotTakeTheDecimalsOfTheFileForQuantisation) {
  for (const double decimals : {3.0, 2.0}) {
    const auto r = hand_motion(
        1, [decimals](Sensor s, int, std::size_t, double v) { return printed(v, decimals + (s == kGyr ? 1 : 0)); });
    EXPECT_EQ(names(examine_raw_values(r, test::sensors())), Names{}) << decimals;
  }
}

TEST(Forensics, DoesNotTakeDegreesWrittenWithFewDecimalsForQuantisation) {
  const double degree = M_PI / 180.0;
  auto r = hand_motion(2);
  for (auto& g : r.gyr_radps)
    for (int k = 0; k < 3; ++k) g[k] = printed(g[k] / degree, 2) * degree;
  EXPECT_EQ(names(examine_raw_values(r, test::sensors())), Names{});
}

TEST(Forensics, DoesNotTakeFloat32ForQuantisation) {
  auto r = hand_motion(3);
  for (auto* column : {&r.acc_mps2, &r.gyr_radps, &r.mag_uT})
    for (auto& v : *column)
      for (int k = 0; k < 3; ++k) v[k] = static_cast<double>(static_cast<float>(v[k] * 1.0173));
  EXPECT_EQ(names(examine_raw_values(r, test::sensors())), Names{});
}

TEST(Forensics, TakesTheFewValuesOfALatticeAtRestForNoRail) {
  const auto r = hand_motion(6, [](Sensor s, int, std::size_t i, double v) {
    return s == kGyr ? 0.0137 * (static_cast<double>(i * i % 7 % 3) - 1.0) : v;
  });
  for (const std::string& name : names(examine_raw_values(r, test::sensors()))) EXPECT_NE(name, "gyr_sat");
}

TEST(Forensics, FindsTheStepOfAQuantisedSensorEvenBelowItsNoise) {
  for (const double lsb : {0.0137, 0.00023}) {
    const auto r = hand_motion(
        4, [lsb](Sensor s, int, std::size_t, double v) { return s == kGyr ? lsb * std::round(v / lsb) : v; });
    const auto f = examine_raw_values(r, test::sensors());
    ASSERT_EQ(names(f), Names{"gyr_quant"}) << lsb;
    EXPECT_TRUE(covers(f.findings[0].parameters.at(0), lsb)) << lsb;
    EXPECT_EQ(f.findings[0].channels.size(), 3U);
  }
}

TEST(Forensics, FindsQuantisationThatLastsForAWhileOnOneAxis) {
  const auto r = hand_motion(5, [](Sensor s, int k, std::size_t i, double v) {
    return s == kAcc && k == 1 && i >= 2000 && i < 3200 ? 0.053 * std::round(v / 0.053) : v;
  });
  const auto f = examine_raw_values(r, test::sensors());
  ASSERT_EQ(names(f), Names{"acc_quant"});
  EXPECT_EQ(f.findings[0].channels, Names{"acc_y"});
  EXPECT_NEAR(f.findings[0].interval_s[0], 40.0, 3.0);
  EXPECT_NEAR(f.findings[0].interval_s[1], 64.0, 3.0);
}

TEST(Forensics, FindsTheLevelAtWhichReadingsPileUp) {
  const auto r =
      hand_motion(6, [](Sensor s, int, std::size_t, double v) { return s == kGyr ? std::clamp(v, -2.51, 2.51) : v; });
  const auto f = examine_raw_values(r, test::sensors());
  ASSERT_EQ(names(f), Names{"gyr_sat"});
  EXPECT_TRUE(covers(f.findings[0].parameters.at(0), 2.51));
  for (std::size_t i = 0; i < kRows; ++i)
    EXPECT_EQ(f.muted(kGyr, i), r.gyr_radps[i].cwiseAbs().maxCoeff() > 2.51 - 1e-9) << i;
}

/// What limits the readings of one sign only does not clip the others in the improved simulation.
TEST(Forensics, TellsTheSideOfALevelThatReadingsOfTheOtherSignGoBeyond) {
  const auto f = examine_raw_values(
      hand_motion(6, [](Sensor s, int, std::size_t, double v) { return s == kGyr ? std::min(v, 1.51) : v; }),
      test::sensors());
  ASSERT_EQ(names(f), Names{"gyr_sat"});
  ASSERT_EQ(f.effects.size(), 1U);
  EXPECT_EQ(f.effects[0].parameters.at("side"), std::vector<double>(3, 1.0));
  const auto both = examine_raw_values(
      hand_motion(6, [](Sensor s, int, std::size_t, double v) { return s == kGyr ? std::clamp(v, -1.51, 1.51) : v; }),
      test::sensors());
  ASSERT_EQ(both.effects.size(), 1U);
  EXPECT_FALSE(both.effects[0].parameters.contains("side"));
}

TEST(Forensics, FindsALevelThatHeldForAWhile) {
  const auto r = hand_motion(7, [](Sensor s, int, std::size_t i, double v) {
    return s == kAcc && i > 3000 && i < 4200 ? std::clamp(v, -11.0, 11.0) : v;
  });
  const auto f = examine_raw_values(r, test::sensors());
  ASSERT_EQ(names(f), Names{"acc_sat"});
  EXPECT_TRUE(covers(f.findings[0].parameters.at(0), 11.0));
  EXPECT_GT(f.findings[0].interval_s[0], 59.0);
  EXPECT_LT(f.findings[0].interval_s[1], 85.0);
}

TEST(Forensics, FindsARailThatACalibrationHasPulledApart) {
  auto r = hand_motion(21);
  const std::vector<std::pair<int, double>> shocks{{0, 157.3}, {1, -157.0}, {0, 156.7}, {2, 131.0}, {1, 90.0}};
  for (std::size_t k = 0; k < shocks.size(); ++k) r.acc_mps2[500 + 400 * k][shocks[k].first] = shocks[k].second;
  const auto f = examine_raw_values(r, test::sensors());
  ASSERT_EQ(f.findings.size(), 1U);
  EXPECT_EQ(f.findings[0].effect, "acc_sat");
  EXPECT_NEAR(f.findings[0].parameters[0].value, 157.0, 0.4);
  ASSERT_EQ(f.effects.size(), 1U) << "the improved simulation clips";
  auto other = r;
  other.acc_mps2[500][0] = 150.0;  // shocks of different sizes are no rail
  EXPECT_TRUE(examine_raw_values(other, test::sensors()).findings.empty());
}

/// A magnetometer turns into its limit and out of it slowly, with noise of many steps.
TEST(Forensics, FindsTheRailThatNoiseRunsInto) {
  constexpr double kStep_uT = 0.015, kNoise_uT = 0.35;
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal(0.0, kNoise_uT);
  auto simulation = test::sensors();
  simulation.magnetometer->noise_sd = kNoise_uT;
  const auto read = [&](double limit_uT) {
    return hand_motion(5, [&](Sensor s, int axis, std::size_t row, double v) {
      if (s != kMag) return v;
      const double swing = axis == 2 ? 60.0 * std::sin(static_cast<double>(row) / 800.0) : v;
      return std::clamp(kStep_uT * std::round((swing + normal(random)) / kStep_uT), -limit_uT, limit_uT);
    });
  };
  const auto f = examine_raw_values(read(3900 * kStep_uT), simulation);
  ASSERT_EQ(names(f), Names{"mag_sat"});
  EXPECT_NEAR(f.findings[0].parameters.at(0).value, 3900 * kStep_uT, kStep_uT);
  EXPECT_EQ(names(examine_raw_values(read(100.0), simulation)), Names{}) << "a body that turns no further";
}

/// The outermost of a few coarse steps that noise reaches now and then is no limit, where the file writes finer ones.
TEST(Forensics, TheTailOfTheNoiseAtRestIsNoRail) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal(0.0, 0.25);
  auto simulation = test::sensors();
  simulation.magnetometer->noise_sd = 0.25;
  io::Recording r = hand_motion(5);
  for (auto& m : r.mag_uT)
    for (int k = 0; k < 3; ++k) m[k] = 0.15 * std::round((50.0 - 10.0 * k + normal(random)) / 0.15);
  for (std::size_t i = 0; i < kRows; i += 900) r.mag_uT[i][0] += 0.01;  // and not all lie on the lattice
  const Names said = names(examine_raw_values(r, simulation));
  EXPECT_EQ(std::count(said.begin(), said.end(), "mag_sat"), 0);
}

TEST(Forensics, DoesNotTakeABodyAtRestOnACoarseLatticeForSaturation) {
  io::Recording r = hand_motion(8);
  for (auto& a : r.acc_mps2) {  // the largest reading is that at rest, and repeats for seconds on a lattice of 0.1
    a.z() = std::min(a.z(), 9.81);
    for (int k = 0; k < 3; ++k) a[k] = 0.137 * std::round(a[k] / 0.137);
  }
  for (std::size_t i = 0; i < kRows; ++i) {
    const double in_bout = std::fmod(static_cast<double>(i) / kRate_hz, 10.0);
    if (in_bout > 2.9) r.acc_mps2[i].z() -= 0.137 * std::round(20.0 * std::sin(M_PI * (in_bout - 2.9) / 7.1));
  }
  EXPECT_EQ(names(examine_raw_values(r, test::sensors())), Names{"acc_quant"});
}

TEST(Forensics, FindsHowOftenAMagnetometerGivesANewValue) {
  for (const std::size_t n : {2U, 5U}) {
    io::Recording r = hand_motion(9);
    for (std::size_t i = 0; i < kRows; ++i) r.mag_uT[i] = r.mag_uT[n * (i / n)];
    const auto f = examine_raw_values(r, test::sensors());
    ASSERT_EQ(names(f), Names{"mag_hold"}) << n;
    EXPECT_EQ(f.findings[0].parameters.at(0).value, static_cast<double>(n));
    EXPECT_FALSE(f.muted(kMag, 10 * n));
    EXPECT_TRUE(f.muted(kMag, 10 * n + 1));
    EXPECT_FALSE(f.muted(kGyr, 10 * n + 1));
  }
}

/// Its edges lie within blocks of fresh rows.
TEST(Forensics, AMagnetometerThatIsSlowForAWhileIsTold) {
  for (const std::size_t n : {3U, 20U}) {
    io::Recording r = hand_motion(9);
    for (std::size_t i = 1230; i < 2770; ++i) r.mag_uT[i] = r.mag_uT[n * (i / n)];
    const auto f = examine_raw_values(r, test::sensors());
    ASSERT_EQ(names(f), Names{"mag_hold"}) << n;
    EXPECT_EQ(std::round(f.findings[0].parameters.at(0).value), static_cast<double>(n));
    EXPECT_NEAR(f.findings[0].interval_s[0], 1230 / kRate_hz, 0.25) << n;
    EXPECT_NEAR(f.findings[0].interval_s[1], 2770 / kRate_hz, 0.25) << n;
  }
}

TEST(Forensics, FindsLostRowsReplacedByTheLast) {
  io::Recording r = hand_motion(10);
  std::mt19937_64 engine(11);
  std::size_t lost = 0;
  for (std::size_t i = 1; i < kRows; ++i) {
    if (engine() % 200 != 0) continue;
    r.acc_mps2[i] = r.acc_mps2[i - 1], r.gyr_radps[i] = r.gyr_radps[i - 1], r.mag_uT[i] = r.mag_uT[i - 1];
    ++lost;
  }
  const auto f = examine_raw_values(r, test::sensors());
  ASSERT_EQ(names(f), Names{"sys_dup"});
  EXPECT_DOUBLE_EQ(f.findings[0].parameters.at(0).value, static_cast<double>(lost) / kRows);
  EXPECT_TRUE(covers(f.findings[0].parameters.at(0), 1.0 / 200));
}

TEST(Forensics, FindsTheDeadZoneOfASelfZeroingGyro) {
  const double d = 0.006;
  const auto r =
      hand_motion(12, [d](Sensor s, int, std::size_t, double v) { return s == kGyr && std::abs(v) < d ? 0.0 : v; });
  const auto f = examine_raw_values(r, test::sensors());
  ASSERT_EQ(names(f), Names{"gyr_deadzone"});
  EXPECT_TRUE(covers(f.findings[0].parameters.at(0), d));
}

TEST(Forensics, SaysNothingOfAnEffectThatTheSimulationAlreadyHas) {
  auto simulation = test::sensors();
  simulation.effects.push_back({.id = "gyr_sat", .parameters = {}, .axes = {}, .window_s = {}});
  const auto r =
      hand_motion(6, [](Sensor s, int, std::size_t, double v) { return s == kGyr ? std::clamp(v, -2.51, 2.51) : v; });
  const auto f = examine_raw_values(r, simulation);
  EXPECT_EQ(names(f), Names{});
  EXPECT_TRUE(f.sensor[kGyr].saturated);
}

TEST(Forensics, FindsTheSlowMagnetometerAndTheLostRowsOfBroad) {
  const std::string path = in_source("../shared/recordings/broad/03_undisturbed_slow_rotation_C.csv");
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "LOUD: SKIPPED, recording absent: " << path;
  const auto r = io::read_recording(path);
  ASSERT_TRUE(r.has_value());
  const auto f = examine_raw_values(*r, test::sensors());
  ASSERT_FALSE(f.findings.empty());
  EXPECT_EQ(f.findings[0].effect, "mag_hold");
  EXPECT_NEAR(f.findings[0].parameters[0].value, 2.82, 0.03);  // 100 Hz in a file of 285.7 Hz
  EXPECT_TRUE(
      f.sensor[kGyr].lattice_step.isApprox(Vec3::Constant(0.0610361 * M_PI / 180), 1e-3));  // 2000 dps in 15 bits
}

}  // namespace
}  // namespace stillpoint::diag
