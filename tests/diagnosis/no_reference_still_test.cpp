/// A recording that lies still in a chamber: temperature laws and their loop against drift and noise.
#include "diagnosis/no_reference/still.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace stillpoint::diag::detail {
namespace {

sim::SimulationConfig on_a_shelf() {
  sim::SimulationConfig s;
  s.accelerometer = sim::TriadConfig{.noise_sd = 0.01};
  s.gyroscope = sim::TriadConfig{.noise_sd = 0.0005};
  return s;
}

/// Up and down between 0 and 60 degC in 2000 s; the accelerometer's z follows k1 tau + k2 tau^2 + k (T - T_L).
io::Recording chamber(double k1, double k2, double k) {
  std::mt19937_64 engine(3);
  std::normal_distribution<double> normal;
  io::Recording r;
  double lagging = 0.0;
  for (int i = 0; i < 8000; ++i) {
    const double t = 0.25 * i, temp = 30.0 - 30.0 * std::cos(2.0 * M_PI * t / 2000.0);
    lagging += (i == 0 ? temp : 0.25 / 80.0 * (temp - lagging));
    const double tau = temp - 25.0;
    r.t_ns.push_back(static_cast<std::int64_t>(std::llround(1e9 * t)));
    r.acc_mps2.emplace_back(0.01 * normal(engine), 0.01 * normal(engine),
                            9.81 + k1 * tau + k2 * tau * tau + k * (temp - lagging) + 0.01 * normal(engine));
    r.gyr_radps.emplace_back(5e-4 * normal(engine), 5e-4 * normal(engine), 5e-4 * normal(engine));
    r.temp_degC.push_back(temp);
  }
  return r;
}

std::vector<std::string> names(const Diagnosis& d) {
  std::vector<std::string> all;
  for (const auto& f : d.findings) all.push_back(f.effect);
  return all;
}

using Names = std::vector<std::string>;

TEST(Still, SaysNothingWhereNothingFollowsTheTemperature) {
  EXPECT_EQ(names(diagnose_still(chamber(0, 0, 0), on_a_shelf())), Names{});
}

TEST(Still, NamesTheLawWithItsSize) {
  const auto d = diagnose_still(chamber(0.005, 0, 0), on_a_shelf());
  ASSERT_EQ(names(d), Names{"acc_temp_lin"});
  EXPECT_NEAR(d.findings[0].parameters[2].value, 0.005, 2e-4);
}

TEST(Still, NamesTheLoopBetweenHeatingAndCoolingBesideTheLaw) {
  const auto d = diagnose_still(chamber(0.005, 2e-4, 0.02), on_a_shelf());
  ASSERT_EQ(names(d), (Names{"acc_temp_quad", "acc_temp_lag"}));
  EXPECT_LT(d.findings[1].held_out.rms_after, 0.7 * d.findings[1].held_out.rms_before);
}

TEST(Still, CallsItDriftWhereTheTemperatureWasNotRecorded) {
  auto r = chamber(0.005, 0, 0);
  r.temp_degC.clear();
  const auto d = diagnose_still(r, on_a_shelf());
  ASSERT_EQ(names(d), Names{"acc_drift"});
  EXPECT_NE(d.findings[0].regime.find("could be thermal"), std::string::npos);
  EXPECT_EQ(d.findings[0].decided_by, "record temp_degC");
}

TEST(Still, LeavesOutALawThatIsNotInTheLibrary) {
  for (const auto& name : names(diagnose_still(chamber(0.005, 0, 0), on_a_shelf(), {"acc_temp_lin"})))
    EXPECT_NE(name, "acc_temp_lin");
}

}  // namespace
}  // namespace stillpoint::diag::detail
