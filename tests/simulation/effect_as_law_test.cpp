/// Effects of the catalogue as laws of the grammar: the simulator adds the same for either.
#include <gtest/gtest.h>

#include "simulation/effect_as_law.h"
#include "tests/simulation/effect_twins.h"

namespace stillpoint::sim {
namespace {

/// Of all three sensors and all rows: what the laws add differently from the effect, over the largest that it adds.
double worst_share(const std::string& yaml) {
  const EffectConfig e = effect(yaml);
  const Twins catalogue({e}, discharging()), written(as_laws(e), discharging());
  double worst = 0.0, largest = 0.0;
  for (const Sensor s : kSensors)
    for (std::size_t i = 0; i < catalogue.size(); ++i) {
      largest = std::max(largest, catalogue.change(s, i).norm());
      worst = std::max(worst, (catalogue.change(s, i) - written.change(s, i)).norm());
    }
  EXPECT_GT(largest, 0.0) << yaml << " was never excited";
  return worst / std::max(largest, 1e-300);
}

TEST(EffectAsLaw, AddsWhatTheEffectAdds) {
  for (const char* yaml :
       {"{effect: acc_temp_lin, k_mps2_per_K: [0.01, -0.02, 0.03]}",
        "{effect: acc_temp_quad, k2_mps2_per_K2: [1e-3, -2e-3, 1e-3], k1_mps2_per_K: [0.01, 0.02, -0.01]}",
        "{effect: gyr_temp_scale, S_per_K: [1e-3, -2e-3, 3e-3]}", "{effect: gyr_volt, k_radps_per_V: [0.1, -0.2, 0.3]}",
        "{effect: acc_quad, k2_per_mps2: [1e-4, -2e-4, 3e-4]}",
        "{effect: gyr_cubic, k3_per_radps_2: [1e-3, 2e-3, -3e-3]}", "{effect: acc_asym, k: [1e-3, -2e-3, 2e-3]}",
        "{effect: acc_gravity, dg_mps2: 0.02}",
        "{effect: acc_alias, b_mps2: [0.1, 0.2, -0.3], f_hz: 7.3, phase_rad: -1}",
        "{effect: gyr_gsens, G_radps_per_mps2: [[0,4e-4,0],[0,0,-3e-4],[2e-4,0,0]], axes: [x, z]}",
        "{effect: gyr_gsens, G_radps_per_mps2: [[0,4e-4,0],[0,0,-3e-4],[2e-4,0,0]], window_s: [10, 20]}",
        "{effect: gyr_earth, w_radps: [1e-5, -6e-5, 3e-5]}", "{effect: mag_hard_step, b_uT: [3, -4, 5], t0_s: 20.005}",
        "{effect: mag_soft_step, M: [[0.01,0,0.02],[0,-0.02,0],[0,0.01,0.03]], t0_s: 20.005}",
        "{effect: mag_field_step, b_world_uT: [3, -4, 5], t0_s: 20.005}",
        "{effect: mag_gradient, G_uT_per_m: [[1,2,3],[2,-4,5],[3,5,3]], b_world_uT: [1, -2, 3]}",
        "{effect: mag_current, k_uT_per_A: [1, -2, 3]}"})
    EXPECT_LT(worst_share(yaml), 1e-6) << yaml;
}

/// A delay of the grammar looks at the true vector at that time; a lag is the exact one of straight lines between rows.
TEST(EffectAsLaw, RemembersAsTheEffectDoes) {
  EXPECT_LT(worst_share("{effect: gyr_delay, tau_s: 0.02}"), 1e-3);
  EXPECT_LT(worst_share("{effect: acc_temp_lag, k_mps2_per_K: [0.01, -0.02, 0.03], tau_s: 20}"), 1e-2);
}

/// The derivative is that of the rates between the rows.
TEST(EffectAsLaw, ALeverIsThreeLaws) {
  EXPECT_LT(worst_share("{effect: acc_lever, r_m: [0.1, 0.2, -0.3]}"), 1e-2);
  EXPECT_LT(worst_share("{effect: acc_size, r_m: [[0.003, 0.001, 0], [0, -0.002, 0.004], [0.005, 0, 0.001]]}"), 1e-2);
}

TEST(EffectAsLaw, IsEmptyWhereTheGrammarHasNoWords) {
  for (const char* yaml :
       {"{effect: gyr_sat, L_radps: [2, 2, 2]}", "{effect: mag_hold, n: 5}", "{effect: gyr_delay, tau_s: -0.01}",
        "{effect: sys_jitter, sd_s: 1e-4}", "{effect: ref_frame, phi_rad: [0.01, 0, 0]}"})
    EXPECT_TRUE(as_laws(effect(yaml)).empty()) << yaml;
}

}  // namespace
}  // namespace stillpoint::sim
