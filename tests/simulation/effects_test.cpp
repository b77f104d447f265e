/// What holds for every effect of the catalogue: whose readings it changes, on which axes and when.
#include "tests/simulation/effect_twins.h"

namespace stillpoint::sim {
namespace {

/// An effect of the given ID, each number at the upper end of its usual range.
EffectConfig typical(const EffectInfo& info) {
  EffectConfig e;
  e.id = info.id;
  for (const auto& p : info.parameters) {
    if (!p.required) continue;
    double value = p.typical_high > 0.0 ? p.typical_high : 20.0;
    if (p.key == "n") value = 3.0;
    if (p.key == "f_hz") value = 20.0;
    if (info.id == "acc_sat") value = 4.0;
    if (info.id == "gyr_sat") value = 1.0;
    if (info.id == "mag_sat") value = 30.0;
    e.parameters[p.key].assign(static_cast<std::size_t>(p.count), value);
  }
  if (info.id == "mag_soft_step") e.parameters["M"] = {0.1, 0, 0, 0, -0.05, 0.02, 0, 0, 0.03};
  if (info.id == "gyr_coning") e.parameters["p_rad"] = {0.0, 1.0, 2.5};
  return e;
}

class EveryEffect : public ::testing::TestWithParam<std::string> {};

TEST_P(EveryEffect, ChangesItsOwnSensorAndNoOther) {
  const EffectInfo& info = *find_effect(GetParam());
  SimulationConfig c = base_config();
  if (info.id.ends_with("_vre")) c.motion->kind = "drone";
  const Twins twins({typical(info)}, c);
  double acc = 0.0, gyr = 0.0, mag = 0.0, reference = 0.0;
  for (std::size_t i = 0; i < twins.size(); ++i) {
    acc += twins.acc(i).norm();
    gyr += twins.gyr(i).norm();
    mag += twins.mag(i).norm();
    reference += twins.on[i].ref_q_world_body.angularDistance(twins.off[i].ref_q_world_body);
    ASSERT_TRUE(vec(twins.on[i].sample.acc_mps2).allFinite() && vec(twins.on[i].sample.gyr_radps).allFinite());
  }
  const bool all = (info.sensor == "sys" && info.id != "sys_tracker") || info.id == "ref_frame";
  EXPECT_EQ(acc > 0.0, all || info.sensor == "acc");
  EXPECT_EQ(gyr > 0.0, all || info.sensor == "gyr" || info.id == "sys_tracker");
  EXPECT_EQ(mag > 0.0, all || info.sensor == "mag");
  EXPECT_EQ(reference > 1e-6, info.id == "ref_error");
}

class EveryEffectWithAWindow : public ::testing::TestWithParam<std::string> {};

TEST_P(EveryEffectWithAWindow, KeepsToItAndToItsAxes) {
  const EffectInfo& info = *find_effect(GetParam());
  EffectConfig e = typical(info);
  if (info.takes_axes()) e.axes = {1};
  e.window_s = {25.0, 40.0};
  SimulationConfig c = base_config();
  if (info.id.ends_with("_vre")) c.motion->kind = "drone";
  const Twins twins({e}, c);
  double inside = 0.0;
  for (std::size_t i = 0; i < twins.size(); ++i) {
    const bool outside = twins.t(i) < 24.9 || twins.t(i) > 40.1;
    for (const Sensor sensor : {Sensor::kAcc, Sensor::kGyr, Sensor::kMag}) {
      const Vec3 d = twins.change(sensor, i);
      ASSERT_TRUE(!outside || d.norm() == 0.0) << twins.t(i);
      ASSERT_TRUE(!info.takes_axes() || (d.x() == 0.0 && d.z() == 0.0)) << twins.t(i);
      inside += std::abs(d.y());
    }
  }
  EXPECT_GT(inside, 0.0);
}

std::vector<std::string> ids(bool with_a_window) {
  std::vector<std::string> out;
  for (const auto& e : effect_catalogue())
    if (!with_a_window || e.takes_window()) out.push_back(e.id);
  return out;
}
INSTANTIATE_TEST_SUITE_P(Catalogue, EveryEffect, ::testing::ValuesIn(ids(false)),
                         [](const auto& i) { return i.param; });
INSTANTIATE_TEST_SUITE_P(Catalogue, EveryEffectWithAWindow, ::testing::ValuesIn(ids(true)),
                         [](const auto& i) { return i.param; });

}  // namespace
}  // namespace stillpoint::sim
