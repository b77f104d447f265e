/// What gravity says against the names of a gyroscope's columns.
#include <gmock/gmock.h>

#include <utility>

#include "core/units.h"
#include "tests/exchange/foreign_files.h"
#include "tests/exchange/importing.h"

namespace stillpoint::exchange {
namespace {

using test::all;
using test::file;
using test::read;
using testing::HasSubstr;
using testing::Not;

/// Turned about all axes, hardly moved.
std::vector<RawSample> tumbled() { return test::moved("tumble"); }

Imported named(const std::vector<RawSample>& samples, const char* unit, double factor) {
  const std::string header = fmt::format("t,ax,ay,az,gyr_x_{0},gyr_y_{0},gyr_z_{0}", unit);
  return read(file(
      "named.csv",
      test::table(samples, {header, ",", 1.0, 0, {{&RawSample::acc_mps2, 1.0}, {&RawSample::gyr_radps, factor}}})));
}

TEST(Gravity, AUnitThatItContradictsIsOverruled) {
  const auto truth = tumbled();
  for (const auto& [name, factor] : {std::pair{"dps", 1.0}, {"radps", kDegPerRad}, {"dps", 1e3 * kDegPerRad}}) {
    const auto imported = named(truth, name, factor);
    ASSERT_EQ(imported.recording.size(), truth.size());
    EXPECT_NEAR(imported.recording.gyr_radps[700].x(), truth[700].gyr_radps[0], 1e-6);
    EXPECT_THAT(all(imported.reasons), HasSubstr(fmt::format("although its name says {}", name)));
  }
}

TEST(Gravity, OtherAxesAreNoReasonToGiveUpAName) {
  auto swapped = tumbled();
  for (auto& s : swapped) std::swap(s.gyr_radps[0], s.gyr_radps[2]);
  const auto imported = named(swapped, "radps", 1.0);
  EXPECT_NEAR(imported.recording.gyr_radps[700].x(), swapped[700].gyr_radps[0], 1e-6);
  EXPECT_THAT(all(imported.reasons), Not(HasSubstr("although")));
}

TEST(Gravity, AxesThatDisagreeAreLoud) {
  auto mirrored = tumbled();
  for (auto& s : mirrored)
    for (double& x : s.gyr_radps) x = -x;
  EXPECT_THAT(all(named(mirrored, "dps", kDegPerRad).reasons), HasSubstr("WARNING"));
}

}  // namespace
}  // namespace stillpoint::exchange
