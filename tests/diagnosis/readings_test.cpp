/// What cannot be a measurement is taken out before anything is fitted, and lost rows are put back as empty ones.
#include "diagnosis/sanity/readings.h"

#include <gmock/gmock.h>

#include <cmath>

#include "tests/diagnosis/simulated.h"

namespace stillpoint::diag {
namespace {

using testing::HasSubstr;

io::Recording clean() { return test::record(test::baseline("exact", 30.0), "", {}, 5); }

/// Sets every 50th reading of a column to `value`; says what is told of it and that just these readings are gone.
template <class Column, class Value>
void expect_taken_out(Column io::Recording::*column, const Value& value, const std::string& words) {
  io::Recording r = clean();
  std::size_t spoiled = 0;
  for (std::size_t i = 7; i < r.size(); i += 50) (r.*column)[i] = value, ++spoiled;
  std::vector<std::string> notices;
  const auto out = without_false_values(r, notices);
  ASSERT_TRUE(out) << words;
  ASSERT_THAT(notices, testing::SizeIs(testing::Ge(1U)));
  EXPECT_THAT(notices[0], HasSubstr(words));
  EXPECT_THAT(notices[0], HasSubstr(std::to_string(spoiled) + " of"));
  std::size_t missing = 0;
  for (const auto& x : (*out).*column) {
    if constexpr (std::is_same_v<std::decay_t<decltype(x)>, double>)
      missing += !std::isfinite(x);
    else
      missing += !x.allFinite();
  }
  EXPECT_EQ(missing, spoiled) << words;
}

TEST(Readings, TakesOutWhatNoSensorMeasures) {
  expect_taken_out(&io::Recording::acc_mps2, Vec3(1e30, 0, 0), "beyond anything a sensor can measure");
  expect_taken_out(&io::Recording::acc_mps2, Vec3(65535, 65535, 65535), "65535 in all three axes");
  expect_taken_out(&io::Recording::acc_mps2, Vec3(0, 0, 0), "0 in all three axes");
  expect_taken_out(&io::Recording::mag_uT, Vec3(-999, -999, -999), "-999 in all three axes");
  expect_taken_out(&io::Recording::gyr_radps, Vec3(35, 35, 35), "35 in all three axes");
  expect_taken_out(&io::Recording::temp_degC, -999.0, "temp_degC");
  expect_taken_out(&io::Recording::ref_q_world_body, Eigen::Vector4d(0, 0, 0, 0), "without unit length");
  expect_taken_out(&io::Recording::ref_position_m, Vec3(1e30, 0, 0), "positions");
}

/// A gyroscope with a dead zone reads noughts at rest; a wrong unit is wrong in every row and is somebody else's to
/// name.
TEST(Readings, LeavesWhatMayBeTrue) {
  std::vector<std::string> notices;
  EXPECT_FALSE(without_false_values(clean(), notices));
  io::Recording r = clean();
  for (std::size_t i = 0; i < r.size(); i += 10) r.gyr_radps[i].setZero();
  EXPECT_FALSE(without_false_values(r, notices));
  for (Vec3& y : r.acc_mps2) y *= 1e7;
  EXPECT_FALSE(without_false_values(r, notices));
  EXPECT_THAT(notices, testing::IsEmpty());
}

TEST(Readings, PutsEmptyRowsWhereSomeWereLost) {
  io::Recording r = clean();
  EXPECT_FALSE(with_lost_rows(r));
  const std::size_t rows = r.size();
  const auto lose = [&r](std::ptrdiff_t first, std::ptrdiff_t last) {
    const auto cut = [&](auto& column) { column.erase(column.begin() + first, column.begin() + last); };
    cut(r.t_ns), cut(r.acc_mps2), cut(r.gyr_radps), cut(r.mag_uT), cut(r.temp_degC), cut(r.current_A), cut(r.supply_V);
    cut(r.ref_q_world_body), cut(r.ref_position_m), cut(r.ref_moving);
  };
  lose(700, 703);
  lose(300, 301);
  const auto even = with_lost_rows(r);
  ASSERT_TRUE(even);
  const io::Recording whole = clean();
  ASSERT_EQ(even->size(), rows);
  EXPECT_EQ(even->t_ns, whole.t_ns);
  for (const std::size_t i : {300U, 700U, 701U, 702U}) EXPECT_FALSE(even->acc_mps2[i].allFinite()) << i;
  EXPECT_EQ(even->ref_q_world_body[703], whole.ref_q_world_body[703]);
  // A jump of an hour is not filled up with an hour of rows.
  for (std::size_t i = 500; i < r.size(); ++i) r.t_ns[i] += 3600'000'000'000;
  EXPECT_LE(with_lost_rows(r)->size(), rows + 50);
}

/// Lost rows with honest times and a noisy reference: differences across them are no physics.
TEST(Readings, LostRowsAreNoPhysics) {
  io::Recording r = test::record(test::baseline("mocap"), "", {}, 11), thinned = r;
  thinned.t_ns.clear(), thinned.acc_mps2.clear(), thinned.gyr_radps.clear(), thinned.mag_uT.clear();
  thinned.temp_degC.clear(), thinned.current_A.clear(), thinned.supply_V.clear(), thinned.ref_moving.clear();
  thinned.ref_q_world_body.clear(), thinned.ref_position_m.clear();
  for (std::size_t i = 0; i < r.size(); ++i) {
    if (i % 97 == 13) continue;
    thinned.t_ns.push_back(r.t_ns[i]), thinned.acc_mps2.push_back(r.acc_mps2[i]);
    thinned.gyr_radps.push_back(r.gyr_radps[i]), thinned.mag_uT.push_back(r.mag_uT[i]);
    thinned.ref_q_world_body.push_back(r.ref_q_world_body[i]), thinned.ref_position_m.push_back(r.ref_position_m[i]);
  }
  EXPECT_THAT(test::names(diagnose(thinned, test::baseline("mocap"))), testing::IsEmpty());
}

}  // namespace
}  // namespace stillpoint::diag
