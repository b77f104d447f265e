/// What is said of a law, and what its text tells.
#include "diagnosis/discovery/law_words.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace stillpoint::diag {
namespace {

TEST(LawWords, ALawThatAMomentAndADriverSwitchIsAWindowItself) {
  EXPECT_TRUE(is_a_window_itself("unknown:abs(f) * step(t, 22.8) * step(d(T), 0.08)"));
  EXPECT_TRUE(is_a_window_itself("unknown:w * step(w_y, -0.6) * step(t, 22.8)"));
  EXPECT_FALSE(is_a_window_itself("unknown:step(t, 21.7) * exp(-(t - 21.7) / 2.4)"));
  EXPECT_FALSE(is_a_window_itself("unknown:m * step(I, 0.9)"));
}

TEST(LawWords, ALawInTheAnswerHasUnitDriversAndMechanisms) {
  Finding finding;
  finding.effect = "unknown:w*(V-V0)";
  finding.channels = {"gyr_x"};
  const auto law = law_json(finding);
  ASSERT_TRUE(law);
  EXPECT_EQ((*law)["text"], "w * (V - 3.7)");
  EXPECT_EQ((*law)["unit"], "rad V/s");
  EXPECT_EQ((*law)["drivers"], nlohmann::ordered_json::array({"w", "V"}));
  EXPECT_THAT((*law)["mechanisms"].dump(), testing::HasSubstr("ratiometric"));
  finding.effect = "unknown:switched(t)";
  EXPECT_FALSE(law_json(finding));
}

}  // namespace
}  // namespace stillpoint::diag
