#include "simulation/simulator.h"

#include <gmock/gmock.h>

#include <numeric>

#include "core/so3.h"
#include "io/simulation_yaml.h"

namespace stillpoint::sim {
namespace {

SimulationConfig config(const std::string& more = "") {
  const auto c = io::parse_simulation(
      "accelerometer: {bias: [0.1, -0.2, 0.3], matrix: [[1.1, 0.02, 0], [0, 0.9, 0.03], [0.01, 0, 1.05]], noise_mps2: "
      "0.02}\n"
      "gyroscope: {bias: [0.01, 0, -0.01], matrix: [[0.98, 0, 0.01], [0, 1.03, 0], [0, 0.02, 1]], noise_radps: 0.001}\n"
      "magnetometer: {bias: [10, -5, 3], matrix: [[1, 0.1, 0], [0, 1.2, 0], [0, 0, 0.9]], noise_uT: 0.3}\n" +
          more,
      "test");
  EXPECT_TRUE(c) << (c ? "" : c.error().message);
  return *c;
}

constexpr const char* kHand = "motion: {kind: hand, duration_s: 60}\n";

TEST(Simulator, ReadsMinusGravityTurnedIntoTheBodyAtRest) {
  auto c = config(kHand);
  c.accelerometer = TriadConfig{};
  for (const auto& row : simulate(c, 1)) {
    if (row.moving) break;
    const Vec3 up = row.true_q_world_body.conjugate() * Vec3(0.0, 0.0, 9.80665);
    ASSERT_LT((vec(row.sample.acc_mps2) - up).norm(), 1e-12);
  }
}

/// u = H (y - B) of the readings is the truth plus H times white noise.
TEST(Simulator, ConfiguredBiasAndMatrixGiveTheTruthBack) {
  const auto c = config(kHand);
  Vec3 mean = Vec3::Zero(), square = Vec3::Zero();
  const auto rows = simulate(c, 1);
  for (const auto& row : rows) {
    const Vec3 u = c.accelerometer->matrix * (vec(row.sample.acc_mps2) - c.accelerometer->bias);
    const Vec3 y_error = c.accelerometer->matrix.inverse() * (u - vec(row.true_acc_mps2));
    mean += y_error / static_cast<double>(rows.size());
    square += y_error.cwiseAbs2() / static_cast<double>(rows.size());
  }
  // 6000 samples: the mean has 0.02 / sqrt(6000), the variance a relative sd of sqrt(2 / 6000); four of each.
  EXPECT_LT(mean.cwiseAbs().maxCoeff(), 4 * 0.02 / std::sqrt(6000.0));
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(square[i] / 4e-4, 1.0, 4 * std::sqrt(2.0 / 6000.0));
}

TEST(Simulator, OneSeedOneRecordingAnotherSeedAnother) {
  const auto a = simulate(config(kHand), 1), same = simulate(config(kHand), 1), other = simulate(config(kHand), 2);
  EXPECT_EQ(a[777].sample.gyr_radps, same[777].sample.gyr_radps);
  EXPECT_NE(a[777].sample.gyr_radps, other[777].sample.gyr_radps);
}

/// Every random source has its own stream: what is switched on beside a sensor leaves that sensor's noise as it was.
TEST(Simulator, SwitchingOneSourceOnLeavesTheOthersAsTheyWere) {
  const std::string effects =
      "effects:\n  - {effect: acc_drift, q_mps2_per_sqrts: 0.01}\n  - {effect: acc_temp_lin, k_mps2_per_K: 0.1}\n";
  const auto plain = simulate(config(kHand), 5), on = simulate(config(kHand + effects), 5);
  const auto walk = simulate(config(kHand + effects.substr(0, effects.rfind("  - "))), 5);
  for (std::size_t i = 0; i < plain.size(); ++i) {
    ASSERT_EQ(plain[i].sample.gyr_radps, on[i].sample.gyr_radps);
    ASSERT_EQ(plain[i].sample.mag_uT, on[i].sample.mag_uT);
    ASSERT_EQ(plain[i].sample.temp_degC, on[i].sample.temp_degC);
  }
  // The walk is the same walk with and without the temperature effect: their difference is the law alone.
  const double tau = 8.0 * (1.0 - std::exp(-50.0 / 60.0));
  const Vec3 law = config().accelerometer->matrix * (vec(on[5000].sample.acc_mps2) - vec(walk[5000].sample.acc_mps2));
  EXPECT_LT((law - Vec3::Constant(0.1 * tau)).norm(), 1e-9);
}

TEST(Simulator, SensorsKeepTheirOwnRates) {
  auto c = config(kHand);
  c.magnetometer->rate_hz = 30.0;
  int readings = 0;
  for (const auto& row : simulate(c, 1)) readings += row.sample.holds(kMag) ? 1 : 0;
  EXPECT_NEAR(readings, 60 * 30, 1);
}

TEST(Simulator, LostRowsAreGoneWithTheirSequenceNumbers) {
  const auto whole = simulate(config(kHand), 1),
             holed = simulate(config(std::string(kHand) + "timing: {lost_fraction: 0.1}\n"), 1);
  EXPECT_NEAR(static_cast<double>(holed.size()), 5400.0, 4 * std::sqrt(6000 * 0.09));
  for (const auto& row : holed) ASSERT_EQ(row.sample.acc_mps2, whole[row.sample.sequence].sample.acc_mps2);
}

TEST(Simulator, MocapReferenceHasTheStatedErrorsAndLeavesTheSensorsAlone) {
  const auto exact = simulate(config(kHand), 1);
  const auto mocap =
      simulate(config(std::string(kHand) +
                      "reference: {kind: mocap, orientation_sd_rad: 0.002, position_sd_m: 3e-4, band_hz: 10}\n"),
               1);
  double turn = 0.0, shift = 0.0;
  for (std::size_t i = 0; i < exact.size(); ++i) {
    ASSERT_EQ(exact[i].sample.acc_mps2, mocap[i].sample.acc_mps2);
    turn += log_quat(exact[i].ref_q_world_body.conjugate() * mocap[i].ref_q_world_body).squaredNorm() / 3.0;
    shift += (exact[i].ref_position_m - mocap[i].ref_position_m).squaredNorm() / 3.0;
  }
  const double n = static_cast<double>(exact.size());
  EXPECT_NEAR(std::sqrt(turn / n), 0.002, 0.0002);  // correlated over 1.6 samples, 18000 numbers: within 10 % surely
  EXPECT_NEAR(std::sqrt(shift / n), 3e-4, 3e-5);
}

TEST(Simulator, MovingIronIsADipole) {
  // 1 A m^2 along x seen from 1 m along x: mu0/(4 pi) 2 m / r^3 = 0.2 uT; from 1 m along y: -0.1 uT.
  auto c = config(
      "motion: {kind: rest_poses, duration_s: 10}\n"
      "environment: {iron: [{moment_Am2: [1, 0, 0], start_m: [-1, 0, 0]}, {moment_Am2: [10, 0, 0], start_m: [0, -1, "
      "0]}]}\n");
  const Environment surroundings(c.environment, *make_motion(*c.motion, 1), {}, 1);
  EXPECT_LT((surroundings.iron_field_uT(Vec3::Zero(), 0.0) - Vec3(0.2 - 1.0, 0.0, 0.0)).norm(), 1e-12);
}

/// The Allan deviation of what was simulated against the terms asked for, within four times its own standard deviation.
TEST(Simulator, NoiseHasTheAllanDeviationAskedFor) {
  constexpr double kStep_s = 0.01, kWhite = 0.01, kFlicker = 0.004, kWalk = 0.0004;
  constexpr std::size_t kSamples = 400000;
  const auto deviation = [&](auto&& source, double tau_s) {
    std::vector<double> x(kSamples);
    for (auto& value : x) value = source.next().x();
    const auto m = static_cast<std::size_t>(std::lround(tau_s / kStep_s));
    // Overlapping Allan variance, written here from its definition so that nothing is shared with the analysis.
    std::vector<double> sum(kSamples + 1, 0.0);
    std::partial_sum(x.begin(), x.end(), sum.begin() + 1);
    double square = 0.0;
    for (std::size_t k = 0; k + 2 * m <= kSamples; ++k)
      square += std::pow((sum[k + 2 * m] - 2.0 * sum[k + m] + sum[k]) / static_cast<double>(m), 2);
    return std::sqrt(square / 2.0 / static_cast<double>(kSamples - 2 * m + 1));
  };
  const auto relative = [&](double tau_s) { return 4.0 / std::sqrt(2.0 * (kSamples * kStep_s / tau_s - 1.0)); };
  for (const double tau_s : {0.1, 1.0, 10.0}) {
    TriadConfig white{.noise_sd = kWhite};
    EXPECT_NEAR(deviation(TriadNoise(white, kStep_s, 1, "a"), tau_s) / (kWhite * std::sqrt(kStep_s / tau_s)), 1.0,
                relative(tau_s));
    EXPECT_NEAR(deviation(FlickerNoise(Vec3::Constant(kFlicker), kStep_s, 1, "b"), tau_s) / (0.664 * kFlicker), 1.0,
                relative(tau_s) + 0.03);
    EXPECT_NEAR(deviation(RandomWalk(Vec3::Constant(kWalk), kStep_s, 1, "c"), tau_s) / (kWalk * std::sqrt(tau_s / 3.0)),
                1.0, relative(tau_s) + 0.02);
  }
}

TEST(Simulator, NormalNumbersAreNormal) {
  Stream random(3, "normal");
  constexpr int kDraws = 2000000;
  double sum = 0.0, square = 0.0, fourth = 0.0;
  int beyond_2 = 0, beyond_4 = 0;
  for (int i = 0; i < kDraws; ++i) {
    const double x = random.normal();
    sum += x;
    square += x * x;
    fourth += x * x * x * x;
    beyond_2 += std::abs(x) > 2.0 ? 1 : 0;
    beyond_4 += std::abs(x) > 4.0 ? 1 : 0;
  }
  EXPECT_NEAR(sum / kDraws, 0.0, 4.0 / std::sqrt(kDraws));
  EXPECT_NEAR(square / kDraws, 1.0, 4.0 * std::sqrt(2.0 / kDraws));
  EXPECT_NEAR(fourth / kDraws, 3.0, 4.0 * std::sqrt(96.0 / kDraws));
  EXPECT_NEAR(beyond_2 / static_cast<double>(kDraws), 0.0455003, 4.0 * std::sqrt(0.0455 / kDraws));
  EXPECT_NEAR(beyond_4, 6.3342e-5 * kDraws, 4.0 * std::sqrt(6.3e-5 * kDraws));
}

}  // namespace
}  // namespace stillpoint::sim
