/// A disturbance of the field that comes and goes while the body turns on a table: fixed in the body or in the world?
#include "diagnosis/no_reference/field.h"

#include <gtest/gtest.h>

#include <random>

namespace stillpoint::diag::detail {
namespace {

constexpr double kRest_s = 4.0, kTurn_s = 2.0, kStep_s = 0.02;
constexpr double kFrom_s = 36.0, kTo_s = 54.0;  // three rests and the turns between them

sim::SimulationConfig table() {
  sim::SimulationConfig s;
  s.accelerometer = sim::TriadConfig{.noise_sd = 0.02};
  s.gyroscope = sim::TriadConfig{.noise_sd = 0.001};
  s.magnetometer = sim::TriadConfig{.noise_sd = 0.3};
  s.field_world_uT = Vec3(0, 20, -43);
  return s;
}

/// Twenty rests, 50 degrees about the vertical between them; `b_uT` is added for a while, in the body or in the world.
io::Recording turned(const Vec3& b_uT, bool in_body, bool turns = true) {
  std::mt19937_64 engine(11);
  std::normal_distribution<double> normal;
  const auto noise = [&](double sd) -> Vec3 { return sd * Vec3(normal(engine), normal(engine), normal(engine)); };
  io::Recording r;
  double heading = 0.0;
  for (int i = 0; i * kStep_s < 20 * (kRest_s + kTurn_s); ++i) {
    const double t = i * kStep_s;
    const double since = std::fmod(t, kRest_s + kTurn_s);
    const double rate = turns && since > kRest_s ? 50.0 * M_PI / 180.0 / kTurn_s : 0.0;
    const Mat3 R = Eigen::AngleAxisd(heading, Vec3::UnitZ()).toRotationMatrix();
    const bool disturbed = t >= kFrom_s && t < kTo_s;
    Vec3 field = R.transpose() * (table().field_world_uT + (disturbed && !in_body ? b_uT : Vec3::Zero()));
    if (disturbed && in_body) field += b_uT;
    r.t_ns.push_back(static_cast<std::int64_t>(std::llround(1e9 * t)));
    r.acc_mps2.push_back(Vec3(0, 0, 9.80665) + noise(0.02));
    r.gyr_radps.push_back(Vec3(0, 0, rate) + noise(0.001));
    r.mag_uT.push_back(field + noise(0.3));
    heading += rate * kStep_s;
  }
  return r;
}

Finding only_finding(const io::Recording& r) {
  const auto found = find_disturbed_field(r, table(), examine_raw_values(r, table()), find_rest(r, table()));
  EXPECT_EQ(found.findings.size(), 1U);
  return found.findings.empty() ? Finding{} : found.findings.front();
}

void expect_there(const Finding& f, const std::string& effect, const Vec3& b_uT) {
  EXPECT_EQ(f.effect, effect) << f.regime;
  EXPECT_NEAR(f.interval_s[0], kFrom_s, 1.0);
  EXPECT_NEAR(f.interval_s[1], kTo_s, 3.0);  // cells at either end of a rest are not used
  ASSERT_EQ(f.parameters.size(), 3U);
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(f.parameters[static_cast<std::size_t>(k)].value, b_uT[k], 0.5) << k;
}

const Vec3 kMagnet_uT(6, -4, 8);

TEST(DisturbedField, WhatWasPutOnTheBodyTurnsWithIt) {
  expect_there(only_finding(turned(kMagnet_uT, true)), "mag_hard_step", kMagnet_uT);
}

TEST(DisturbedField, WhatWasLaidBesideItStandsInTheWorld) {
  // The world of the answer is the body as it lay before, five turns from the start.
  const Vec3 seen = Eigen::AngleAxisd(-5 * 50.0 * M_PI / 180.0, Vec3::UnitZ()) * kMagnet_uT;
  expect_there(only_finding(turned(kMagnet_uT, false)), "mag_field_step", seen);
}

TEST(DisturbedField, WithoutATurnItIsOneOrTheOther) {
  const Finding f = only_finding(turned(kMagnet_uT, false, false));
  EXPECT_EQ(f.effect, "unknown:m(t)");
  EXPECT_EQ(f.equivalent, (std::vector<std::string>{"mag_field_step", "mag_hard_step"}));
  EXPECT_NE(f.decided_by.find("turn the body by 90 degrees"), std::string::npos);
}

TEST(DisturbedField, AnUndisturbedFieldIsNotTouched) {
  const auto r = turned(Vec3::Zero(), false);
  EXPECT_TRUE(find_disturbed_field(r, table(), examine_raw_values(r, table()), find_rest(r, table())).findings.empty());
}

}  // namespace
}  // namespace stillpoint::diag::detail
