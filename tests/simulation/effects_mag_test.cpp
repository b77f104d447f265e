/// The defining property - equation, sign, frame, unit - of the magnetometer's effects.
#include "tests/simulation/effect_twins.h"

namespace stillpoint::sim {
namespace {

TEST(Law, MagTempLinFollowsTheTemperatureAgainst25Degrees) {
  SimulationConfig c = base_config();  // from below 25 degC to above: the sign changes on the way
  c.environment.temperature = {.kind = "warm_up", .start_degC = 17.0, .rise_K = 16.0, .tau_s = 30.0};
  expect_law(
      "{effect: mag_temp_lin, k_uT_per_K: [1, -2, 0.5]}", Sensor::kMag,
      [](const Twins& w, std::size_t i) { return Vec3((8.0 - 16.0 * std::exp(-w.t(i) / 30.0)) * kK); }, 1e-9, c);
}

TEST(Law, MagTempScaleFollowsTheTemperatureAndTheField) {
  expect_law("{effect: mag_temp_scale, S_per_K: [1, -2, 0.5]}", Sensor::kMag, [](const Twins& w, std::size_t i) {
    return Vec3((temp_at(w.t(i)) - 25.0) * kK.cwiseProduct(w.field(i)));
  });
}

TEST(Law, MagSatBelowItsRailIsAnOddNonlinearity) {
  expect_law(
      "{effect: mag_sat, L_uT: 1e9, k3_per_uT_2: [1, -2, 0.5]}", Sensor::kMag,
      [](const Twins& w, std::size_t i) { return Vec3(kK.array() * w.field(i).array().cube()); }, 1e-6);
}

TEST(Law, MagFieldsFixedInTheWorldTurnWithTheBody) {
  const auto in_body = [](const Twins& w, std::size_t i, const Vec3& v) {
    return Vec3(w.on[i].true_q_world_body.conjugate() * v);
  };
  expect_law("{effect: mag_field_step, b_world_uT: [5, 0, -3], t0_s: 20}", Sensor::kMag,
             [&](const Twins& w, std::size_t i) {
               return w.t(i) > 20.0 ? in_body(w, i, {5, 0, -3}) : Vec3::Zero();
             });
  expect_law("{effect: mag_gradient, G_uT_per_m: [[1, 2, 3], [2, 4, 5], [3, 5, -5]]}", Sensor::kMag,
             [&](const Twins& w, std::size_t i) {
               const Vec3 p = w.on[i].true_position_m;
               return in_body(w, i,
                              {p.x() + 2 * p.y() + 3 * p.z(), 2 * p.x() + 4 * p.y() + 5 * p.z(),
                               3 * p.x() + 5 * p.y() - 5 * p.z()});
             });
}

TEST(Law, MagFieldsFixedInTheBodyDoNot) {
  expect_law("{effect: mag_hard_step, b_uT: [1, -2, 0.5], t0_s: 20}", Sensor::kMag,
             [](const Twins& w, std::size_t i) { return w.t(i) > 20.0 ? kK : Vec3::Zero(); });
  expect_law("{effect: mag_flip, b_uT: [1, -2, 0.5]}", Sensor::kMag,
             [](const Twins&, std::size_t i) { return i % 2 == 0 ? kK : Vec3(-kK); });
}

/// Iron in the body: a matrix on the field as the body sees it, row by row, and nothing before it is there.
TEST(Law, MagSoftStepIsAMatrixOnTheFieldInTheBody) {
  expect_law("{effect: mag_soft_step, M: [[0.1, 0.02, 0], [-0.03, 0, 0.05], [0, 0.04, -0.2]], t0_s: 20.005}",
             Sensor::kMag, [](const Twins& w, std::size_t i) {
               if (w.t(i) < 20.005) return Vec3(Vec3::Zero());
               const Vec3 m = w.on[i].true_q_world_body.conjugate() * Vec3(0.0, 20.0, -43.0);
               return Vec3(0.1 * m.x() + 0.02 * m.y(), -0.03 * m.x() + 0.05 * m.z(), 0.04 * m.y() - 0.2 * m.z());
             });
}

/// In the body whatever the attitude, within a sample of the switching, with the sign of the current.
TEST(Law, MagCurrentFollowsTheCurrentInTheBody) {
  expect_law(
      "{effect: mag_current, k_uT_per_A: [1, -2, 0.5]}", Sensor::kMag,
      [](const Twins& w, std::size_t i) { return Vec3(load_at(w.t(i)) * kK); }, 1e-9, base_config(), switched_load());
}

/// Mains of 60 Hz sampled at 100 Hz is a line at -40 Hz; below half the rate a line stays where it is.
TEST(Law, MagLineFoldsAboutHalfTheRate) {
  const auto turns = [](double per_row, double phase) {
    return [=](const Twins&, std::size_t i) {
      return Vec3(std::sin(2.0 * M_PI * per_row * static_cast<double>(i) + phase) * kK);
    };
  };
  expect_law("{effect: mag_line, b_uT: [1, -2, 0.5], f_hz: 60, phase_rad: 0.7}", Sensor::kMag, turns(-0.4, 0.7));
  expect_law("{effect: mag_line, b_uT: [1, -2, 0.5], f_hz: 12}", Sensor::kMag, turns(0.12, 0.0));
}

TEST(Law, StaleHoldRepeatsExactlyEveryNth) {
  const Twins twins({effect("{effect: mag_hold, n: 4}")});
  for (std::size_t i = 0; i < twins.size(); ++i) {
    ASSERT_EQ(twins.on[i].sample.mag_uT, twins.off[i - i % 4].sample.mag_uT);
    ASSERT_EQ(twins.acc(i).norm(), 0.0);
  }
}

TEST(Law, StaleHoldOfAResampledFileLastsAPartOfARowMoreOnAverage) {
  constexpr double kRows = 2.8;
  const Twins twins({effect("{effect: mag_hold, n: 2.8}")});
  std::size_t fresh = 0;
  for (std::size_t i = 0; i < twins.size(); ++i) {
    const auto part = static_cast<std::size_t>(std::floor(static_cast<double>(i) / kRows));
    const auto since = static_cast<std::size_t>(std::ceil(static_cast<double>(part) * kRows));
    ASSERT_EQ(twins.on[i].sample.mag_uT, twins.off[since].sample.mag_uT) << i;
    fresh += since == i ? 1 : 0;
  }
  EXPECT_NEAR(static_cast<double>(twins.size()) / static_cast<double>(fresh), kRows, 0.01);
}

}  // namespace
}  // namespace stillpoint::sim
