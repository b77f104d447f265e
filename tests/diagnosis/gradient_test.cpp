/// The gradient of a field: five numbers that a field without sources can have, about a zero that nobody knows.
#include <gmock/gmock.h>

#include "diagnosis/reference/columns.h"
#include "tests/diagnosis/simulated.h"

namespace stillpoint::diag {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::IsEmpty;

const std::vector<double> kG{20, 10, 0, 10, -30, 5, 0, 5, 10};

TEST(Gradient, IsSymmetricWithoutATrace) {
  const Mat3 G = gradient_of(Eigen::VectorXd::LinSpaced(5, 1.0, 5.0));
  EXPECT_EQ(G, G.transpose());
  EXPECT_EQ(G.trace(), 0.0);
}

/// For a while only, in a room whose zero is 5 m away.
TEST(Gradient, IsOneCauseWhereverTheZeroOfThePositionsIs) {
  auto config = test::baseline("exact", 60.0);
  sim::SimulationConfig with = config;
  with.effects.push_back(
      {.id = "mag_gradient", .parameters = {{"G_uT_per_m", kG}}, .axes = {}, .window_s = {{20.0, 40.0}}});
  io::Recording r = test::record(with, "", {}, 31);
  const Vec3 zero(4, -3, 1);
  for (Vec3& p : r.ref_position_m) p += zero;
  const Answer answer = diagnose(r, config);
  ASSERT_THAT(test::names(answer), ElementsAre("mag_gradient")) << answer.diagnosis.summary;
  const auto& told = answer.diagnosis.findings.front().parameters;
  ASSERT_EQ(told.size(), 9U);
  for (std::size_t i = 0; i < 9; ++i) {
    EXPECT_NEAR(told[i].value, kG[i], 2.0 * (told[i].ci95[1] - told[i].value)) << told[i].name;
    EXPECT_LT(told[i].ci95[1] - told[i].ci95[0], 2.0) << told[i].name;
  }
  EXPECT_NEAR(told[0].value + told[4].value + told[8].value, 0.0, 1e-9);

  ASSERT_EQ(answer.effects.size(), 1U);
  const auto& b = answer.effects[0].parameters.at("b_world_uT");
  const Vec3 there = -Eigen::Map<const Mat3>(kG.data()) * zero;
  for (std::size_t axis = 0; axis < 3; ++axis) EXPECT_NEAR(b[axis], there[static_cast<Eigen::Index>(axis)], 2.0);
  config.effects = answer.effects;
  EXPECT_THAT(test::names(diagnose(r, config)), IsEmpty()) << "it is in the simulation now";
}

}  // namespace
}  // namespace stillpoint::diag
