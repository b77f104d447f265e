/// The strength of an effect: rms over noise, and d' whitened with the noise configured, H and B projected out.
#include "simulation/strength.h"

#include <Eigen/Dense>

#include "tests/simulation/effect_twins.h"

namespace stillpoint::sim {
namespace {

/// Covariance of the configured noise of one axis between two rows, from the definitions: white; first-order noise;
/// 1/f noise as processes whose time constants are a factor 4 apart, from a quarter of a step up to 1e5 s; a random
/// walk from zero.
double covariance(const TriadConfig& c, int axis, double step_s, double i, double j) {
  const double apart_s = std::abs(i - j) * step_s, sd = c.noise_sd * c.noise_axes[axis];
  double sum = c.noise_band_hz > 0.0 ? sd * sd * std::exp(-2.0 * M_PI * c.noise_band_hz * apart_s)
               : i == j              ? sd * sd
                                     : 0.0;
  for (double tau_s = step_s / 4.0; tau_s < 1e5; tau_s *= 4.0)
    sum += c.bias_instability * c.bias_instability * std::log(4.0) / M_PI * std::exp(-apart_s / tau_s);
  return sum + c.random_walk_per_sqrts * c.random_walk_per_sqrts * step_s * std::min(i, j);
}

/// The whole covariance of the record, its Cholesky factor, a QR of the whitened regressors.
double dense_d_prime(const SimulationConfig& config, const TriadConfig& triad, SamplePart part, Array3 RawSample::*slot,
                     Array3 SimulatedSample::*truth, std::uint64_t seed) {
  SimulationConfig without = config;
  without.effects.clear();
  const std::shared_ptr<const Motion> motion = make_motion(*config.motion, seed);
  const auto on = simulate(config, motion, seed), off = simulate(without, motion, seed);
  std::vector<std::size_t> rows;
  for (std::size_t i = 0; i < on.size(); ++i)
    if (on[i].sample.holds(part)) rows.push_back(i);
  const auto n = static_cast<Eigen::Index>(rows.size());
  double square = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    const auto k = static_cast<std::size_t>(axis);
    Eigen::MatrixXd C(n, n), X(n, 4);
    Eigen::VectorXd d(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const auto &a = on[rows[static_cast<std::size_t>(i)]], &b = off[rows[static_cast<std::size_t>(i)]];
      d[i] = (a.sample.*slot)[k] - (b.sample.*slot)[k];
      X.row(i) << 1.0, vec(a.*truth).transpose();
      for (Eigen::Index j = 0; j < n; ++j)
        C(i, j) = covariance(triad, axis, 1.0 / config.rate_hz, static_cast<double>(a.sample.sequence),
                             static_cast<double>(on[rows[static_cast<std::size_t>(j)]].sample.sequence));
    }
    const Eigen::LLT<Eigen::MatrixXd> llt(C);
    const Eigen::MatrixXd whitened = llt.matrixL().solve(X);
    const Eigen::VectorXd change = llt.matrixL().solve(d);
    square += (change - whitened * whitened.colPivHouseholderQr().solve(change)).squaredNorm();
  }
  return std::sqrt(square);
}

SimulationConfig tumbling(const std::string& more) {
  auto c = *io::parse_simulation(
      "motion: {kind: tumble, duration_s: 4}\n"
      "accelerometer: {noise_mps2: 0.02, noise_axes: [1, 3, 0.5], matrix: [[1.2, 0.1, 0], [0, 0.8, 0], [0, 0, 1]]}\n"
      "gyroscope: {noise_radps: 0.001, bias_instability_radps: 5e-4, random_walk_radps_per_sqrts: 2e-3}\n"
      "magnetometer: {noise_uT: 0.3, noise_band_hz: 4, random_walk_uT_per_sqrts: 0.2, rate_hz: 40}\n" +
          more,
      "test");
  return c;
}

TEST(Strength, AgreesWithTheWholeCovarianceOfTheRecord) {
  const auto check = [](const std::string& yaml) {
    const auto c = tumbling(yaml);
    const auto found = effect_strengths(c, make_motion(*c.motion, 3), 3, {}).at(0);
    const double acc =
        dense_d_prime(c, *c.accelerometer, kAcc, &RawSample::acc_mps2, &SimulatedSample::true_acc_mps2, 3);
    const double gyr = dense_d_prime(c, *c.gyroscope, kGyr, &RawSample::gyr_radps, &SimulatedSample::true_gyr_radps, 3);
    const double mag = dense_d_prime(c, *c.magnetometer, kMag, &RawSample::mag_uT, &SimulatedSample::true_mag_uT, 3);
    EXPECT_GT(acc + gyr + mag, 1.0);
    EXPECT_NEAR(found.sensor[0].d_prime, acc, 1e-6 * (1.0 + acc)) << yaml;
    EXPECT_NEAR(found.sensor[1].d_prime, gyr, 1e-6 * (1.0 + gyr)) << yaml;
    EXPECT_NEAR(found.sensor[2].d_prime, mag, 1e-6 * (1.0 + mag)) << yaml;
  };
  check("effects: [{effect: sys_offset, tau_s: 0.02}]\n");
  check("effects: [{effect: gyr_temp_lin, k_radps_per_K: 0.1}]\n");
  check("effects: [{effect: sys_offset, tau_s: 0.02, window_s: [1, 2]}]\ntiming: {lost_fraction: 0.2}\n");
  check("effects: [{effect: mag_hold, n: 4}]\n");
}

/// A constant offset and a linear map are wrong numbers, not effects: their d' is nothing. What H and B cannot take
/// stays.
TEST(Strength, TakesBiasAndMatrixOff) {
  auto config = *io::parse_simulation(
      "accelerometer: {noise_mps2: 0.02}\nmotion: {kind: hand, duration_s: 60}\neffects:\n"
      "  - {effect: acc_temp_lin, k_mps2_per_K: 0.01}\n  - {effect: acc_temp_scale, S_per_K: 0.001}\n"
      "environment: {temperature: {kind: constant, start_degC: 35}}\n",
      "x");
  const std::shared_ptr<const Motion> motion = make_motion(*config.motion, 2);
  const auto constant = effect_strengths(config, motion, 2, {});
  EXPECT_NEAR(constant[0].sensor[0].rms_over_noise, 0.1 / 0.02, 1e-6);
  EXPECT_LT(constant[0].sensor[0].d_prime, 1e-3);
  EXPECT_GT(constant[1].sensor[0].rms_over_noise, 1.0);
  EXPECT_LT(constant[1].sensor[0].d_prime, 1e-3);
  config.environment.temperature = {.kind = "warm_up", .start_degC = 25.0, .rise_K = 10.0};
  const auto warming = effect_strengths(config, motion, 2, {});
  EXPECT_GT(warming[0].sensor[0].d_prime, 50.0);
  EXPECT_EQ(warming[0].sensor[1].d_prime, 0.0);
}

/// A random walk hides what is slow and leaves what is fast: the slow warm-up loses almost all of its d', the line of a
/// motor hardly any.
TEST(Strength, RandomWalkHidesWhatIsSlow) {
  const auto d_prime = [](const std::string& walk, const std::string& effect_yaml) {
    const auto c =
        *io::parse_simulation("gyroscope: {noise_radps: 0.001" + walk +
                                  "}\nmotion: {kind: hand, duration_s: 60}\neffects: [" + effect_yaml + "]\n",
                              "x");
    return effect_strengths(c, make_motion(*c.motion, 2), 2, {}).at(0).sensor[1].d_prime;
  };
  const std::string walk = ", random_walk_radps_per_sqrts: 1e-3";
  const std::string slow = "{effect: gyr_temp_lin, k_radps_per_K: 1e-3}";
  const std::string fast = "{effect: gyr_alias, b_radps: 1e-3, f_hz: 30}";
  EXPECT_LT(d_prime(walk, slow), 0.2 * d_prime("", slow));
  EXPECT_NEAR(d_prime(walk, fast) / d_prime("", fast), 1.0, 0.02);
  // A sine of amplitude b in white noise s on three axes over n rows: sqrt(3 n / 2) b / s, less what H and B take.
  EXPECT_NEAR(d_prime("", fast), std::sqrt(1.5 * 6000.0), 0.5);
}

/// The second of two entries keeps its random numbers while the first is taken off for its twin.
TEST(Strength, OfOneOfTwoRandomEntriesIsItsOwn) {
  SimulationConfig c = base_config();
  const EffectConfig e = effect("{effect: gyr_drift, q_radps_per_sqrts: [0.01, 0.01, 0.01]}");
  const std::shared_ptr<const Motion> motion = make_motion(*c.motion, 4);
  c.effects = {e};
  const double alone = effect_strengths(c, motion, 4, {}).at(0).sensor[1].rms_over_noise;
  c.effects = {e, e};
  const auto both = effect_strengths(c, motion, 4, {});
  EXPECT_NEAR(both[0].sensor[1].rms_over_noise, alone, 1e-9 * alone);
  EXPECT_GT(std::abs(both[1].sensor[1].rms_over_noise - alone), 1e-3 * alone);
}

}  // namespace
}  // namespace stillpoint::sim
