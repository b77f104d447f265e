// Nothing is missing, whatever the body does: every motion of the simulator, rests or none, with and without a camera's
// noise.
#include <gmock/gmock.h>

#include "diagnosis/summary.h"
#include "tests/diagnosis/simulated.h"

namespace stillpoint::diag {
namespace {

using Clean = std::tuple<std::string, std::string, double>;

class CleanMotion : public testing::TestWithParam<Clean> {};
INSTANTIATE_TEST_SUITE_P(Diagnosis, CleanMotion,
                         testing::Combine(testing::Values("rest_poses", "hand", "turntable", "tumble", "walking",
                                                          "vehicle", "boat", "drone"),
                                          testing::Values("exact", "mocap"), testing::Values(100.0, 200.0)),
                         [](const auto& p) {
                           return std::get<0>(p.param) + "_" + std::get<1>(p.param) + "_" +
                                  std::to_string(static_cast<int>(std::get<2>(p.param)));
                         });

TEST_P(CleanMotion, RaisesNoAlarm) {
  const auto& [kind, reference, rate_hz] = GetParam();
  sim::SimulationConfig config = test::baseline(reference, 60.0);
  config.rate_hz = rate_hz;
  config.motion->kind = kind;
  config.motion->vibration_hz = 40.0;  // with its second harmonic beyond what a reference of 100 rows a second carries
  config.motion->vibration_mps2 = 6.0;
  const Answer answer = diagnose(test::record(config, "", {}, 11), config);
  EXPECT_THAT(test::names(answer), testing::IsEmpty()) << to_text(answer.diagnosis);
}

}  // namespace
}  // namespace stillpoint::diag
