/// Which topics, and which clock, are taken out of the logs of flight controllers and robots.
#include <gmock/gmock.h>

#include "tests/exchange/foreign_files.h"
#include "tests/exchange/importing.h"

namespace stillpoint::exchange {
namespace {

using test::all;
using test::file;
using test::read;
using testing::HasSubstr;

TEST(Logs, OfTwoTopicsOfPx4TheFasterIsTakenAndNamed) {
  const auto truth = test::hand();
  const auto imported = read(file("default.ulg", test::ulog(truth, 100)));
  const auto& r = imported.recording;
  ASSERT_EQ(r.size(), truth.size());
  for (std::size_t i = 0; i < truth.size(); ++i) {
    ASSERT_LT((r.acc_mps2[i] - vec(truth[i].acc_mps2)).norm(), 1e-4) << "row " << i;
    ASSERT_LT((r.gyr_radps[i] - vec(truth[i].gyr_radps)).norm(), 1e-4) << "row " << i;
  }
  EXPECT_EQ(r.temp_degC.at(100), 31.5);
  EXPECT_THAT(all(imported.reasons), HasSubstr("default.ulg sensor_combined is taken for acc: it has 2000 readings"));
}

}  // namespace
}  // namespace stillpoint::exchange
