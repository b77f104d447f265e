/// What holds for every effect of the catalogue: whose readings it changes, on which axes and when.
#include <filesystem>
#include <fstream>

#include "simulation/strength.h"
#include "tests/simulation/effect_twins.h"
#include "tests/source_folder.h"

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

bool same_reference(const SimulatedSample& a, const SimulatedSample& b) {
  return a.ref_q_world_body.coeffs() == b.ref_q_world_body.coeffs() && a.ref_position_m == b.ref_position_m;
}

/// Readings, not differences of corrected ones: bit for bit.
TEST_P(EveryEffect, LeavesReadingsOutsideItsWindowAndOnOtherAxesAsTheyWere) {
  const EffectInfo& info = *find_effect(GetParam());
  EffectConfig e = typical(info);
  e.axes = {1};
  e.window_s = {25.0, 40.0};
  SimulationConfig c = base_config();
  if (info.id.ends_with("_vre")) c.motion->kind = "drone";
  for (auto* triad : {&c.accelerometer, &c.gyroscope, &c.magnetometer}) (*triad)->bias = Vec3(0.3, -0.2, 0.7);
  const Twins twins({e}, c);
  int changed = 0;
  for (std::size_t i = 0; i < twins.size(); ++i) {
    const SimulatedSample &on = twins.on[i], &off = twins.off[i];
    for (const auto slot : {&RawSample::acc_mps2, &RawSample::gyr_radps, &RawSample::mag_uT}) {
      const Array3 &with = on.sample.*slot, &without = off.sample.*slot;
      ASSERT_TRUE(with[0] == without[0] && with[2] == without[2]) << twins.t(i);
      changed += with[1] != without[1] ? 1 : 0;
      if (twins.t(i) < 25.0 || twins.t(i) > 40.0) {
        ASSERT_EQ(with[1], without[1]) << twins.t(i);
      }
    }
    if (same_reference(on, off)) continue;
    ++changed;
    ASSERT_EQ(info.id, "ref_error");
    ASSERT_TRUE(twins.t(i) >= 25.0 && twins.t(i) <= 40.0) << twins.t(i);
    const Vec3 turn = log_quat(off.ref_q_world_body.conjugate() * on.ref_q_world_body);
    ASSERT_LT(std::hypot(turn.x(), turn.z()), 1e-9);  // about the body's y; log_quat of a small turn rounds
    ASSERT_EQ(on.ref_position_m.x(), off.ref_position_m.x());
    ASSERT_EQ(on.ref_position_m.z(), off.ref_position_m.z());
  }
  EXPECT_GT(changed, 0);
}

/// What --truth states of every effect: rms over noise and d' where it acts, nothing where it does not.
TEST_P(EveryEffect, HasAStrengthInItsOwnSensorsAndInNoOther) {
  const EffectInfo& info = *find_effect(GetParam());
  SimulationConfig c = base_config();
  c.motion->duration_s = 40.0;
  if (info.id.ends_with("_vre")) c.motion->kind = "drone";
  c.effects = {typical(info)};
  const auto strength = effect_strengths(c, make_motion(*c.motion, 4), 4, {}).at(0);
  EXPECT_EQ(strength.effect, info.id);
  const bool all = (info.sensor == "sys" && info.id != "sys_tracker") || info.id == "ref_frame";
  for (const Sensor sensor : kSensors) {
    const Strength& found = strength.sensor[static_cast<std::size_t>(sensor)];
    const bool acts = all || info.sensor == prefix(sensor) || (info.id == "sys_tracker" && sensor == Sensor::kGyr);
    EXPECT_EQ(found.rms_over_noise > 0.0, acts) << prefix(sensor);
    // A rotation of all sensors is a change of H in each: nothing of it is left.
    if (info.id != "ref_frame")
      EXPECT_EQ(found.d_prime > 0.0, acts) << prefix(sensor);
    else
      EXPECT_LT(found.d_prime, 1e-3 * found.rms_over_noise);
    // Taking H and B off can only make it smaller: |change| over all three axes and rows, in units of the noise.
    EXPECT_LE(found.d_prime, found.rms_over_noise * std::sqrt(3.0 * 4000.0) * (1.0 + 1e-9));
  }
}

/// Where an effect acts on several sensors, one of them may be chosen.
TEST_P(EveryEffect, LeavesSensorsThatWereNotChosenAsTheyWere) {
  const EffectInfo& info = *find_effect(GetParam());
  if (!info.takes_sensors()) return;
  EffectConfig e = typical(info);
  e.sensors = {Sensor::kGyr};
  const Twins twins({e});
  double gyr = 0.0;
  for (std::size_t i = 0; i < twins.size(); ++i) {
    ASSERT_EQ(twins.on[i].sample.acc_mps2, twins.off[i].sample.acc_mps2);
    ASSERT_EQ(twins.on[i].sample.mag_uT, twins.off[i].sample.mag_uT);
    gyr += twins.gyr(i).norm();
  }
  EXPECT_GT(gyr, 0.0);
}

/// A fault on one axis gives that axis what the fault on all axes gives it, filters and laws included, and the other
/// axes what they had: the split of a triad is bookkeeping, no physics.
class EveryFaultThatMovesAnAxis : public ::testing::TestWithParam<std::string> {};

TEST_P(EveryFaultThatMovesAnAxis, GivesThatAxisWhatItWouldHaveHadWithTheOthers) {
  SimulationConfig c = base_config();
  for (const char* other : {"{effect: acc_lpf, tau_s: 0.01}", "{effect: acc_resonance, f_hz: 30, zeta: 0.1}",
                            "{effect: acc_vre, k_per_mps2: 1e-3}", "{effect: gyr_lpf, tau_s: 0.01}",
                            "{effect: gyr_temp_lag, k_radps_per_K: 0.01, tau_s: 10}",
                            "{effect: gyr_gsens, G_radps_per_mps2: [0, 0, 0, 0, 0, 0, 1e-3, 2e-3, 0]}"})
    c.effects.push_back(effect(other));
  const auto with = [&](const std::vector<int>& axes, bool fault) {
    SimulationConfig one = c;
    EffectConfig e = typical(*find_effect(GetParam()));
    e.axes = axes;
    if (fault) one.effects.push_back(e);
    return simulate(one, 4);
  };
  const auto none = with({}, false), whole = with({}, true), split = with({2}, true);
  for (std::size_t i = 0; i < none.size(); ++i)
    for (const auto slot : {&RawSample::acc_mps2, &RawSample::gyr_radps, &RawSample::mag_uT}) {
      const Array3 &a = none[i].sample.*slot, &b = whole[i].sample.*slot, &one = split[i].sample.*slot;
      ASSERT_TRUE(one[0] == a[0] && one[1] == a[1] && one[2] == b[2]) << i;
    }
}

INSTANTIATE_TEST_SUITE_P(Catalogue, EveryFaultThatMovesAnAxis,
                         ::testing::Values("acc_delay", "gyr_delay", "mag_delay", "sys_offset", "sys_skew", "sys_gap",
                                           "sys_jitter", "sys_dup", "ref_frame"),
                         [](const auto& i) { return i.param; });

/// The table is no longer than what is tested of it: each ID stands in a test of its own equation, outside this file.
TEST(EffectCatalogue, EveryIdHasATestOfItsEquation) {
  std::string tests;
  for (const auto& file : std::filesystem::directory_iterator(in_source("tests/simulation"))) {
    const std::string name = file.path().filename();
    if (!name.starts_with("effects_") || name == "effects_test.cpp") continue;
    std::ifstream in(file.path());
    tests.append(std::istreambuf_iterator<char>(in), {});
  }
  for (const auto& info : effect_catalogue())
    EXPECT_NE(tests.find("\"{effect: " + info.id), std::string::npos) << info.id << " has no test of its equation";
}

std::vector<std::string> ids() {
  std::vector<std::string> out;
  for (const auto& e : effect_catalogue()) out.push_back(e.id);
  return out;
}
INSTANTIATE_TEST_SUITE_P(Catalogue, EveryEffect, ::testing::ValuesIn(ids()), [](const auto& i) { return i.param; });

}  // namespace
}  // namespace stillpoint::sim
