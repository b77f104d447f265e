/// Effects written as laws and tables: what the simulator adds is what the formula says, and mistakes are explained.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/units.h"
#include "io/simulation_yaml.h"
#include "simulation/law_effect.h"
#include "simulation/simulator.h"

namespace stillpoint::sim {
namespace {

using testing::HasSubstr;

constexpr const char* kBase = R"(
rate_hz: 50
accelerometer: {noise_mps2: 0}
gyroscope: {noise_radps: 0}
magnetometer: {noise_uT: 0}
motion: {kind: hand, duration_s: 20}
environment:
  temperature: {kind: warm_up, noise_K: 0}
  current: {kind: steps, noise_A: 0}
effects:
)";

Result<SimulationConfig> with(const std::string& effects) { return io::parse_simulation(kBase + effects, "sim.yaml"); }

std::vector<SimulatedSample> rows_with(const std::string& effects) {
  const auto config = with(effects);
  EXPECT_TRUE(config) << (config ? "" : config.error().message);
  return config ? simulate(*config, 5) : std::vector<SimulatedSample>{};
}

/// The largest deviation of what the effect adds to `sensor` from `expected` of the row.
template <class Expected>
double worst(const std::string& effects, Array3 RawSample::*sensor, Expected expected) {
  const auto plain = rows_with("  []"), changed = rows_with(effects);
  double out = plain.size() == changed.size() && plain.size() > 900 ? 0.0 : 1e9;
  for (std::size_t i = 0; i < std::min(plain.size(), changed.size()); ++i) {
    const Vec3 delta = vec(changed[i].sample.*sensor) - vec(plain[i].sample.*sensor);
    out = std::max(out, (delta - expected(plain[i])).norm());
  }
  return out;
}

TEST(LawEffect, AddsKTimesANumber) {
  const double off = worst("  - {effect: law, sensor: acc, law: \"norm(w) * (T - 25)\", k: [0.1, -0.2, 0.3]}",
                           &RawSample::acc_mps2, [](const SimulatedSample& s) -> Vec3 {
                             return s.true_rate_radps.norm() * (s.sample.temp_degC - 25.0) * Vec3(0.1, -0.2, 0.3);
                           });
  EXPECT_LT(off, 1e-9);
}

TEST(LawEffect, AMatrixTimesAVectorFromATimeOn) {
  Mat3 M;
  M << 0.1, 0.2, 0.3, 0.0, -0.1, 0.4, 0.5, 0.0, 0.2;
  const double off = worst(
      "  - {effect: law, sensor: gyr, law: \"f * I\", matrix: [[0.1, 0.2, 0.3], [0, -0.1, 0.4], [0.5, 0, 0.2]], "
      "from_s: "
      "5, to_s: 15}",
      &RawSample::gyr_radps, [&](const SimulatedSample& s) -> Vec3 {
        const double t = in_seconds(s.sample.t_ns);
        return t < 5.0 || t > 15.0 ? Vec3(Vec3::Zero()) : Vec3(s.current_A * (M * vec(s.true_acc_mps2)));
      });
  EXPECT_LT(off, 1e-9);
}

TEST(LawEffect, TauIsALag) {
  const auto config = with("  - {effect: law, sensor: mag, law: \"I\", k: [1, 1, 1], tau_s: 2}");
  ASSERT_TRUE(config);
  const auto tree = tree_of(config->effects.front());
  ASSERT_TRUE(tree);
  EXPECT_EQ(laws::text(*tree), "lag(I, 2)");
}

TEST(LawEffect, ATableIsMetAtItsPointsAndStaysBetweenThem) {
  const Curve curve({0.0, 1.0, 2.0, 4.0}, {1.0, 3.0, 3.0, -1.0});
  EXPECT_EQ(curve.at(1.0), 3.0);
  EXPECT_EQ(curve.at(4.0), -1.0);
  for (double x = 0.0; x <= 4.0; x += 0.01) {
    EXPECT_LE(curve.at(x), 3.0 + 1e-12);
    EXPECT_GE(curve.at(x), -1.0 - 1e-12);
  }
  EXPECT_NEAR(curve.at(1.5), 3.0, 1e-12);  // flat between equal points
  EXPECT_FALSE(curve.covers(4.1));
}

TEST(LawEffect, ATableLeftByItsDriverIsTold) {
  const auto outside = [](const std::string& end) {
    const auto config =
        with("  - {effect: table, sensor: acc, driver: \"norm(w)\", x: [0, 0.1], y: [[0, 1], [0, 1], [0, 1]]" + end);
    EXPECT_TRUE(config);
    Simulator simulator(*config, make_motion(*config->motion, 5), 5);
    for (SimulatedSample row; simulator.next(row);) {
    }
    return simulator.outside_table();
  };
  EXPECT_TRUE(outside("}"));
  EXPECT_FALSE(outside(", clamp: true}"));
}

TEST(LawEffect, ReadsBackToTheSame) {
  for (const char* entry :
       {"{effect: law, sensor: acc, law: \"norm(w) * (T - 25)\", k: [0.1, -0.2, 0.3]}",
        "{effect: law, sensor: gyr, law: \"motor_rpm * f\", matrix: [[1, 0, 0], [0, 1, 0], [0, 0, 1]], tau_s: 4, "
        "from_s: 2}",
        "{effect: table, sensor: mag, driver: \"I\", clamp: true, x: [0, 1], y: [[0, 1], [0, 2], [0, 3]], to_s: 9}"}) {
    const auto first = with(std::string("  - ") + entry);
    ASSERT_TRUE(first) << first.error().message;
    const std::string text = io::format_effect(first->effects.front());
    const auto second = with("  - " + text);
    ASSERT_TRUE(second) << text;
    EXPECT_EQ(io::format_effect(second->effects.front()), text);
    EXPECT_EQ(second->effects.front().parameters, first->effects.front().parameters);
    EXPECT_EQ(second->effects.front().window_s, first->effects.front().window_s);
  }
}

TEST(LawEffect, MistakesAreExplainedWhereTheyStand) {
  const auto told = [](const std::string& entry) {
    const auto config = with("  - " + entry);
    return config ? std::string() : config.error().message;
  };
  EXPECT_THAT(told("{effect: law, sensor: acc, law: \"norm(w) * Q\", k: [1, 1, 1]}"),
              HasSubstr("sim.yaml:11:37: 'law', column 11: unknown driver 'Q'"));
  EXPECT_THAT(told("{effect: law, sensor: acc, law: \"w + f\", k: [1, 1, 1]}"), HasSubstr("unlike units"));
  EXPECT_THAT(told("{effect: law, law: \"w\", k: [1, 1, 1]}"), HasSubstr("acc, gyr or mag"));
  EXPECT_THAT(told("{effect: law, sensor: acc, law: \"T\", matrix: [[1,0,0],[0,1,0],[0,0,1]]}"),
              HasSubstr("no meaning"));
  EXPECT_THAT(told("{effect: law, sensor: acc, law: \"T\"}"), HasSubstr("either 'k'"));
  EXPECT_THAT(told("{effect: law, sensor: acc, law: \"T\", k: [1, 2]}"), HasSubstr("2 numbers"));
  EXPECT_THAT(told("{effect: law, sensor: acc, low: \"T\", k: [1, 2, 3]}"), HasSubstr("low"));
  EXPECT_THAT(told("{effect: table, sensor: acc, driver: \"T\", x: [1, 1], y: [[0,1],[0,1],[0,1]]}"),
              HasSubstr("must increase"));
  EXPECT_THAT(told("{effect: table, sensor: acc, driver: \"T\", x: [1, 2], y: [[0,1],[0,1]]}"),
              HasSubstr("three rows"));
}

}  // namespace
}  // namespace stillpoint::sim
