/// Filters against their transfer functions: gain and phase measured tone by tone, and what they must leave alone.
#include <complex>

#include "tests/simulation/effect_twins.h"
#include "tests/simulation/shaken.h"

namespace stillpoint::sim {
namespace {

using Complex = std::complex<double>;
using Transfer = std::function<Complex(double frequency_hz)>;

constexpr double kFast_hz = 2000.0, kLength_s = 6.0, kSettled_s = 4.0;

struct Record {
  std::vector<SimulatedSample> rows;
  [[nodiscard]] double value(Sensor s, std::size_t i) const {
    return s == Sensor::kAcc ? rows[i].sample.acc_mps2[0] : rows[i].sample.gyr_radps[2];
  }
  /// Complex amplitude of a tone over the last two seconds, whole cycles of every tone used here.
  [[nodiscard]] Complex amplitude(Sensor s, double frequency_hz) const {
    Complex sum = 0.0;
    const auto first = static_cast<std::size_t>(kSettled_s * kFast_hz);
    for (std::size_t i = first; i < rows.size(); ++i)
      sum += value(s, i) * std::polar(1.0, -2.0 * M_PI * frequency_hz * static_cast<double>(i) / kFast_hz);
    return 2.0 * sum / static_cast<double>(rows.size() - first);
  }
};

Record shaken(const std::vector<EffectConfig>& effects, double frequency_hz, Sensor sensor) {
  SimulationConfig c = base_config();
  c.rate_hz = kFast_hz;
  c.motion.reset();
  c.effects = effects;
  for (auto* triad : {&c.accelerometer, &c.gyroscope, &c.magnetometer}) (*triad)->noise_sd = 0.0;
  const bool turn = sensor == Sensor::kGyr;
  const ShakenBody::Tone tone{frequency_hz, turn ? 0.0 : 3.0, turn ? 1.0 : 0.0};
  return {simulate(c, std::make_shared<ShakenBody>(std::vector{tone}, kLength_s), 1)};
}

/// Filters take their input as straight between calls 0.5 ms apart, which costs a tone (w h)^2 / 12 of its amplitude:
/// 0.4 % at 70 Hz; the tolerance is that share of the gain expected.
void expect_transfer(const std::string& yaml, Sensor sensor, const Transfer& h) {
  for (const double f : {1.0, 5.0, 14.0, 33.0, 40.0, 70.0}) {
    const Complex measured =
        shaken({effect(yaml)}, f, sensor).amplitude(sensor, f) / shaken({}, f, sensor).amplitude(sensor, f);
    const double straight = std::pow(2.0 * M_PI * f / kFast_hz, 2) / 12.0;
    EXPECT_NEAR(std::abs(measured) / std::abs(h(f)), 1.0, straight + 2e-4) << yaml << " gain at " << f << " Hz";
    EXPECT_NEAR(std::arg(measured / h(f)), 0.0, straight + 2e-4) << yaml << " phase at " << f << " Hz";
  }
}

Transfer low_pass(double tau_s) {
  return [=](double f) { return 1.0 / (1.0 + Complex(0.0, 2.0 * M_PI * f * tau_s)); };
}
Transfer resonance(double f_hz, double zeta) {
  return [=](double f) { return 1.0 / (1.0 - std::pow(f / f_hz, 2) + Complex(0.0, 2.0 * zeta * f / f_hz)); };
}

TEST(Filter, AccLowPassHasTheGainAndPhaseOfOneOverOnePlusTauS) {
  expect_transfer("{effect: acc_lpf, tau_s: 0.008}", Sensor::kAcc, low_pass(0.008));
}

TEST(Filter, GyrLowPassHasTheGainAndPhaseOfOneOverOnePlusTauS) {
  expect_transfer("{effect: gyr_lpf, tau_s: 0.004}", Sensor::kGyr, low_pass(0.004));
}

/// Below, at and above its frequency: gain 1/(2 zeta) and a quarter of a turn at resonance, opposite phase far above.
TEST(Filter, AccResonanceHasTheGainAndPhaseOfItsSecondOrder) {
  expect_transfer("{effect: acc_resonance, f_hz: 40, zeta: 0.1}", Sensor::kAcc, resonance(40.0, 0.1));
  const Complex at_peak = resonance(40.0, 0.1)(40.0);
  EXPECT_NEAR(std::abs(at_peak), 5.0, 1e-9);
  EXPECT_NEAR(std::arg(at_peak), -M_PI / 2.0, 1e-9);
}

/// After a shock the mount swings at sqrt(1 - zeta^2) f_n and loses exp(-2 pi zeta / sqrt(1 - zeta^2)) each time.
TEST(Filter, AccResonanceRingsAtItsDampedFrequency) {
  SimulationConfig c = base_config();
  c.rate_hz = kFast_hz;
  c.motion.reset();
  c.effects = {effect("{effect: acc_resonance, f_hz: 20, zeta: 0.05}")};
  c.accelerometer->noise_sd = 0.0;
  const auto jolt = std::make_shared<ShakenBody>(std::vector<ShakenBody::Tone>{{50.0, 20.0, 0.0}}, 3.0, 1.0, 1.01);
  const auto rows = simulate(c, jolt, 1);
  std::vector<std::size_t> tops;
  for (std::size_t i = 2100; i + 1 < rows.size(); ++i) {
    const auto x = [&](std::size_t k) { return rows[k].sample.acc_mps2[0]; };
    if (x(i) > x(i - 1) && x(i) >= x(i + 1) && x(i) > 0.01) tops.push_back(i);
  }
  ASSERT_GT(tops.size(), 10U);
  const double root = std::sqrt(1.0 - 0.05 * 0.05), cycle = kFast_hz / (20.0 * root);
  EXPECT_NEAR(static_cast<double>(tops[10] - tops[0]) / 10.0, cycle, 0.2);
  const double lost = rows[tops[10]].sample.acc_mps2[0] / rows[tops[0]].sample.acc_mps2[0];
  EXPECT_NEAR(std::log(lost) / 10.0, -2.0 * M_PI * 0.05 / root, 0.01);
}

/// A filter passes what stands still: at rest nothing changes, and the axes across the motion never do.
TEST(Filter, LeavesRestAndTheAxesAcrossTheMotionAlone) {
  for (const char* yaml : {"{effect: acc_lpf, tau_s: 0.008}", "{effect: acc_resonance, f_hz: 40, zeta: 0.1}"}) {
    const Record on = shaken({effect(yaml)}, 5.0, Sensor::kAcc), off = shaken({}, 5.0, Sensor::kAcc);
    for (std::size_t i = 0; i < on.rows.size(); ++i) {
      ASSERT_NEAR(on.rows[i].sample.acc_mps2[1], off.rows[i].sample.acc_mps2[1], 1e-12);
      ASSERT_NEAR(on.rows[i].sample.acc_mps2[2], off.rows[i].sample.acc_mps2[2], 1e-12);
      ASSERT_EQ(on.rows[i].sample.gyr_radps, off.rows[i].sample.gyr_radps);
    }
  }
  const Twins hand({effect("{effect: gyr_lpf, tau_s: 0.005}")});
  for (std::size_t i = 0; hand.on[i].moving == false; ++i) ASSERT_EQ(hand.gyr(i).norm(), 0.0);
}

/// <f_hf^2> of a vibration of amplitude A is A^2 / 2 on its axis: k A^2 / 2 while it lasts, in the unit of the sensor,
/// nothing before, nothing from gravity, nothing on the axes that do not shake, gone within a second afterwards.
TEST(Filter, VibrationRectificationIsTheMeanSquareOfTheFastForce) {
  SimulationConfig c = base_config();
  c.rate_hz = kFast_hz;
  c.motion.reset();
  const auto motion = std::make_shared<ShakenBody>(std::vector<ShakenBody::Tone>{{30.0, 4.0, 0.0}}, 30.0, 10.0, 20.0);
  const auto plain = simulate(c, motion, 1);
  c.effects = {effect("{effect: acc_vre, k_per_mps2: [1e-3, 5e-3, 5e-3]}"),
               effect("{effect: gyr_vre, k_radps_per_mps2_2: [2e-4, 1e-3, 1e-3]}")};
  const auto on = simulate(c, motion, 1);
  const auto mean = [&](double from_s, double to_s, Sensor s, std::size_t axis) {
    double sum = 0.0;
    const auto first = static_cast<std::size_t>(from_s * kFast_hz), last = static_cast<std::size_t>(to_s * kFast_hz);
    for (std::size_t i = first; i < last; ++i)
      sum += s == Sensor::kAcc ? on[i].sample.acc_mps2[axis] - plain[i].sample.acc_mps2[axis]
                               : on[i].sample.gyr_radps[axis] - plain[i].sample.gyr_radps[axis];
    return sum / static_cast<double>(last - first);
  };
  // The running mean (0.5 s) passes 1/(2 pi 30 0.5) of the tone, and five averaging times leave 0.7 % to settle.
  EXPECT_NEAR(mean(14.0, 19.9, Sensor::kAcc, 0), 1e-3 * 8.0, 0.01 * 8e-3);
  EXPECT_NEAR(mean(14.0, 19.9, Sensor::kGyr, 0), 2e-4 * 8.0, 0.01 * 1.6e-3);
  for (const Sensor s : {Sensor::kAcc, Sensor::kGyr}) {
    EXPECT_EQ(mean(1.0, 9.0, s, 0), 0.0);
    EXPECT_LT(std::abs(mean(24.0, 30.0, s, 0)), 1e-5);
    EXPECT_NEAR(mean(14.0, 19.9, s, 1), 0.0, 1e-12);
    EXPECT_NEAR(mean(14.0, 19.9, s, 2), 0.0, 1e-12);
  }
}

}  // namespace
}  // namespace stillpoint::sim
