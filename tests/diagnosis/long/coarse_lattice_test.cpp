/// Steps coarser than the noise: what is no larger than their rounding is no law, what is larger is one.
#include <gmock/gmock.h>

#include "diagnosis/discovery/law_words.h"
#include "tests/diagnosis/simulated.h"

namespace stillpoint::diag {
namespace {

constexpr double kStep_radps = 1.07e-3;

std::vector<std::string> named_beside(double offset_radps) {
  auto config = test::baseline("exact", 60.0);
  config.rate_hz = 100;
  config.motion->kind = "tumble";
  config.gyroscope->noise_sd = 3e-4;
  io::Recording r = test::record(config, "", {}, 5);
  for (std::size_t i = 0; i < r.size(); ++i)
    for (double& w : r.gyr_radps[i]) {
      if (3 * i > 2 * r.size()) w += offset_radps;
      w = kStep_radps * std::round(w / kStep_radps);
    }
  return test::names(diagnose(r, config));
}

TEST(CoarseLattice, HidesNoOffsetThatIsLargerThanItsRounding) {
  EXPECT_THAT(named_beside(1.2e-3), testing::Contains(testing::StartsWith("unknown:")));
}

TEST(CoarseLattice, IsNoLaw) { EXPECT_THAT(named_beside(0.0), testing::Each(testing::EndsWith("_quant"))); }

/// At rest the rounding leaves an error in the mean that motion does not have: that looks like an asymmetry. A real one
/// removes more. So it is where the simulation states more noise than there is.
TEST(CoarseLattice, IsNoAsymmetryAndHidesNone) {
  for (const auto& [asymmetry, stated_radps] : {std::pair{0.0, 4.3e-4}, {0.0, 6e-4}, {5e-4, 4.3e-4}}) {
    auto config = test::baseline("exact", 60.0), truth = config;
    for (auto* c : {&config, &truth}) {
      c->rate_hz = 100;
      c->motion->kind = "rest_poses";
      c->gyroscope->noise_sd = c == &config ? stated_radps : 3e-4;  // 4.3e-4 with its rounding
      c->gyroscope->bias = Vec3(2.5e-4, -1.3e-3, 8.5e-4);
      c->accelerometer->noise_sd = 0.0045;
    }
    truth.effects.push_back({.id = "gyr_quant",
                             .parameters = {{"q_radps", std::vector<double>(3, kStep_radps)}},
                             .axes = {},
                             .window_s = {}});
    for (const std::uint64_t seed : {1, 2, 13}) {
      const std::string id = asymmetry > 0 ? "gyr_asym" : "";
      const auto said =
          test::names(diagnose(test::record(truth, id, {{"k", {asymmetry, -asymmetry, asymmetry}}}, seed), config));
      const auto law = testing::Contains("gyr_asym");
      EXPECT_TRUE(asymmetry > 0 ? testing::Value(said, law) : !testing::Value(said, law)) << asymmetry << " " << seed;
    }
  }
}

}  // namespace
}  // namespace stillpoint::diag
