/// Effects on the reading y itself - rails, lattices, dead zones - row by row against the reading without them.
#include "tests/simulation/effect_twins.h"

namespace stillpoint::sim {
namespace {

using Change = std::function<double(double y, int axis)>;

/// y with the effect is `change` of y without it, on every axis of this sensor, and no other sensor's y changes. H and
/// B are not the plain ones: these effects act on y and know nothing of u.
void expect_reading(const std::string& yaml, Array3 RawSample::*slot, const Change& change, double tolerance) {
  SimulationConfig c = base_config();
  for (auto* triad : {&c.accelerometer, &c.gyroscope, &c.magnetometer}) {
    (*triad)->bias = Vec3(0.03, -0.02, 0.07);
    (*triad)->matrix << 1.2, 0.1, -0.2, 0.05, 0.8, 0.15, -0.1, 0.2, 1.1;
  }
  const Twins twins({effect(yaml)}, c);
  std::array<int, 3> changed{};
  for (std::size_t i = 0; i < twins.size(); ++i)
    for (const auto other : {&RawSample::acc_mps2, &RawSample::gyr_radps, &RawSample::mag_uT})
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const double with = (twins.on[i].sample.*other)[axis], without = (twins.off[i].sample.*other)[axis];
        if (other != slot) {
          ASSERT_EQ(with, without);
          continue;
        }
        ASSERT_NEAR(with, change(without, static_cast<int>(axis)), tolerance) << yaml << " row " << i;
        changed[axis] += with != without ? 1 : 0;
      }
  for (const int count : changed) EXPECT_GT(count, 20) << yaml << ": an axis was never touched";
}

double between(double y, double level) { return y > level ? level : y < -level ? -level : y; }
double on_lattice(double y, double q) {
  const double below = std::floor(y / q) * q;
  return y - below < 0.5 * q ? below : below + q;
}

TEST(Reading, SaturationClipsEachAxisAtItsOwnRail) {
  expect_reading(
      "{effect: acc_sat, L_mps2: [6, 5, 4]}", &RawSample::acc_mps2,
      [](double y, int axis) { return between(y, axis == 0   ? 6.0
                                                 : axis == 1 ? 5.0
                                                             : 4.0); }, 0.0);
  expect_reading(
      "{effect: gyr_sat, L_radps: [0.8, 0.5, 0.3]}", &RawSample::gyr_radps,
      [](double y, int axis) { return between(y, axis == 0   ? 0.8
                                                 : axis == 1 ? 0.5
                                                             : 0.3); }, 0.0);
  expect_reading(
      "{effect: mag_sat, L_uT: [20, 15, 30]}", &RawSample::mag_uT,
      [](double y, int axis) { return between(y, axis == 0   ? 20.0
                                                 : axis == 1 ? 15.0
                                                             : 30.0); }, 0.0);
}

TEST(Reading, SaturationOfOneSideLeavesReadingsOfTheOtherSign) {
  expect_reading(
      "{effect: gyr_sat, L_radps: [0.8, 0.5, 0.3], side: [1, -1, 0]}", &RawSample::gyr_radps,
      [](double y, int axis) { return axis == 0   ? std::min(y, 0.8)
                                      : axis == 1 ? std::max(y, -0.5)
                                                  : between(y, 0.3); },
      0.0);
}

/// Half a step at most, on a lattice through zero whose step is the axis' own.
TEST(Reading, QuantisationTakesTheNearestPointOfTheLattice) {
  expect_reading(
      "{effect: acc_quant, q_mps2: [0.01, 0.05, 0.002]}", &RawSample::acc_mps2,
      [](double y, int axis) { return on_lattice(y, axis == 0   ? 0.01
                                                    : axis == 1 ? 0.05
                                                                : 0.002); }, 1e-12);
  expect_reading(
      "{effect: gyr_quant, q_radps: [0.001, 0.005, 0.0002]}", &RawSample::gyr_radps,
      [](double y, int axis) { return on_lattice(y, axis == 0   ? 0.001
                                                    : axis == 1 ? 0.005
                                                                : 0.0002); }, 1e-12);
  expect_reading(
      "{effect: mag_quant, q_uT: [0.1, 0.5, 0.02]}", &RawSample::mag_uT,
      [](double y, int axis) { return on_lattice(y, axis == 0   ? 0.1
                                                    : axis == 1 ? 0.5
                                                                : 0.02); }, 1e-12);
}

TEST(Reading, DeadZoneSwallowsWhatIsSmallAndNothingElse) {
  expect_reading(
      "{effect: gyr_deadzone, d_radps: [0.05, 0.1, 0.2]}", &RawSample::gyr_radps,
      [](double y, int axis) {
        const double d = axis == 0 ? 0.05 : axis == 1 ? 0.1 : 0.2;
        return y > -d && y < d ? 0.0 : y;
      },
      0.0);
}

/// Hidden behind a low-pass the rail is one of the filter's input: no reading stands on it, and where the input stays
/// within the rail nothing is lost.
TEST(Reading, HiddenSaturationClipsBeforeTheFilter) {
  const auto lpf = effect("{effect: acc_lpf, tau_s: 0.02}");
  SimulationConfig c = base_config();
  c.effects = {lpf};
  c.accelerometer->noise_sd = 0.0;
  const auto filtered = simulate(c, 4);
  c.effects = {effect("{effect: acc_sat, L_mps2: 8, hidden: 1}"), lpf};
  const auto hidden = simulate(c, 4);
  int lower = 0, on_rail = 0, moving_on_rail = 0;
  for (std::size_t i = 0; i < hidden.size(); ++i) {
    const double y = hidden[i].sample.acc_mps2[2];
    ASSERT_LE(std::abs(y), 8.0 + 1e-9);
    lower += std::abs(y) < std::abs(filtered[i].sample.acc_mps2[2]) - 1e-3 ? 1 : 0;
    on_rail += std::abs(std::abs(filtered[i].sample.acc_mps2[2]) - 8.0) < 1e-9 ? 1 : 0;
    moving_on_rail += hidden[i].moving && y == 8.0 ? 1 : 0;
  }
  EXPECT_GT(lower, 100);
  EXPECT_EQ(on_rail, 0);
  EXPECT_EQ(moving_on_rail, 0);
}

}  // namespace
}  // namespace stillpoint::sim
