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

}  // namespace
}  // namespace stillpoint::diag
