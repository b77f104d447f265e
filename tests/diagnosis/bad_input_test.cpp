/// The whole diagnosis on input that cannot be right: the mistake stands in the verdict, no physics is blamed for it,
/// and the answer is valid JSON.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "diagnosis/summary.h"
#include "tests/diagnosis/simulated.h"

namespace stillpoint::diag {
namespace {

using testing::HasSubstr;

io::Recording clean() { return test::record(test::baseline("exact", 40.0), "", {}, 21); }

Diagnosis diagnosed(const io::Recording& r) { return diagnose(r, test::baseline("exact")).diagnosis; }

void expect_input_blamed(const io::Recording& r, const std::string& words) {
  const Diagnosis d = diagnosed(r);
  EXPECT_EQ(d.verdict, Verdict::kInsufficientData) << words;
  EXPECT_THAT(test::names(d), testing::IsEmpty()) << words;
  EXPECT_THAT(d.summary, HasSubstr(words));
  const auto json = nlohmann::json::parse(to_json(d));  // NaN and infinity do not parse
  EXPECT_EQ(json["verdict"], "insufficient_data");
}

TEST(BadInput, AWrongUnitIsNoPhysics) {
  io::Recording r = clean();
  for (Vec3& y : r.acc_mps2) y /= 9.80665;
  expect_input_blamed(r, "g instead of m/s^2");
  r = clean();
  for (Vec3& y : r.gyr_radps) y *= 57.29578;
  expect_input_blamed(r, "degrees per second");
  r = clean();
  for (Vec3& y : r.mag_uT) y *= 1000;
  expect_input_blamed(r, "nT instead of uT");
  r = clean();
  for (Vec3& p : r.ref_position_m) p *= 1000;
  expect_input_blamed(r, "millimetres");
  r = clean();
  for (auto& t : r.t_ns) t *= 1000;
  expect_input_blamed(r, "unit");
}

TEST(BadInput, AWrongFrameIsNoPhysics) {
  io::Recording r = clean();
  for (auto& q : r.ref_q_world_body) q.tail<3>() *= -1;
  expect_input_blamed(r, "conjugated");
  r = clean();
  for (auto& q : r.ref_q_world_body) q = Eigen::Vector4d(q[1], q[2], q[3], q[0]);
  expect_input_blamed(r, "x,y,z,w");
  r = clean();
  for (Vec3& p : r.ref_position_m) p = Vec3(p.y(), p.x(), -p.z());
  expect_input_blamed(r, "reference position");
}

TEST(BadInput, AColumnWithoutNumbersIsSaid) {
  io::Recording r = clean();
  for (Vec3& y : r.acc_mps2) y.setConstant(io::kMissing);
  expect_input_blamed(r, "acc_x, acc_y, acc_z: no reading");
  r = clean();
  for (Vec3& y : r.gyr_radps) y.setZero();
  expect_input_blamed(r, "every reading is 0");
}

TEST(BadInput, AReferenceWithGapsEverywhereIsSaid) {
  io::Recording r = clean();
  for (std::size_t i = 0; i < r.size(); ++i)
    if (i % 5 != 0) r.ref_q_world_body[i].setConstant(io::kMissing), r.ref_position_m[i].setConstant(io::kMissing);
  expect_input_blamed(r, "stand beside a reference without a break");
}

TEST(BadInput, TooLittleIsSaid) {
  for (const std::size_t rows : {1U, 3U, 50U, 100U}) {
    io::Recording r = clean();
    r.t_ns.resize(rows), r.acc_mps2.resize(rows), r.gyr_radps.resize(rows), r.mag_uT.resize(rows);
    r.temp_degC.resize(rows), r.current_A.resize(rows), r.supply_V.resize(rows), r.ref_moving.resize(rows);
    r.ref_q_world_body.resize(rows), r.ref_position_m.resize(rows);
    expect_input_blamed(r, "too short");
  }
}

/// Not recorded is no mistake, and no agreement either.
TEST(BadInput, AnAbsentSensorIsNamedInTheSummary) {
  io::Recording r = clean();
  r.mag_uT.clear();
  const Diagnosis d = diagnosed(r);
  EXPECT_EQ(d.verdict, Verdict::kNoMismatch);
  EXPECT_THAT(d.summary, HasSubstr("not compared: mag"));
}

/// A clock of the simulation that follows a temperature, beside a recording without one.
TEST(BadInput, AnEffectWhoseDriverIsNotRecordedIsLeftIn) {
  io::Recording r = clean();
  r.temp_degC.clear();
  sim::SimulationConfig given = test::baseline("exact");
  given.effects = {
      {.id = "sys_skew", .parameters = {{"eps_ppm", {0}}, {"k_ppm_per_K", {50}}}, .axes = {}, .window_s = {}}};
  EXPECT_THAT(diagnose(r, given).diagnosis.notices,
              testing::Contains(HasSubstr("effect sys_skew of the simulation cannot be predicted")));
}

}  // namespace
}  // namespace stillpoint::diag
