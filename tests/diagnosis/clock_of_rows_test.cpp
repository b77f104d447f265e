/// What is said of times is said in the recording's own stamps, whatever was lost before.
#include <gtest/gtest.h>

#include "tests/diagnosis/simulated.h"

namespace stillpoint::diag {
namespace {

template <class T>
void erase_rows(std::vector<T>& column, std::ptrdiff_t first, std::ptrdiff_t last) {
  if (!column.empty()) column.erase(column.begin() + first, column.begin() + last);
}

TEST(Times, AStepAfterALongBreakIsWhereTheStampsHaveIt) {
  const auto config = test::baseline("exact", 80.0);
  io::Recording r = test::record(config, "mag_hard_step", {{"b_uT", {4.0, -3.0, 5.0}}, {"t0_s", {50.0}}}, 7);
  constexpr std::ptrdiff_t kFirst = 20 * 50, kLast = 29 * 50;
  erase_rows(r.t_ns, kFirst, kLast), erase_rows(r.acc_mps2, kFirst, kLast), erase_rows(r.gyr_radps, kFirst, kLast);
  erase_rows(r.mag_uT, kFirst, kLast), erase_rows(r.temp_degC, kFirst, kLast), erase_rows(r.current_A, kFirst, kLast);
  erase_rows(r.supply_V, kFirst, kLast), erase_rows(r.ref_q_world_body, kFirst, kLast);
  erase_rows(r.ref_position_m, kFirst, kLast), erase_rows(r.ref_moving, kFirst, kLast);
  const Answer answer = diagnose(r, config);
  ASSERT_EQ(test::names(answer).size(), 1U) << answer.diagnosis.summary;
  EXPECT_EQ(answer.diagnosis.findings[0].effect, "mag_hard_step");
  EXPECT_NEAR(answer.diagnosis.findings[0].interval_s[0], 50.0, 0.2);
  ASSERT_EQ(answer.effects.size(), 1U);
  EXPECT_NEAR(answer.effects[0].parameters.at("t0_s")[0], 50.0, 0.2);
}

}  // namespace
}  // namespace stillpoint::diag
