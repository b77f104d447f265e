/// Which topics, and which clock, are taken out of the logs of flight controllers and robots.
#include <gmock/gmock.h>

#include "exchange/mcap_writer.h"
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

TEST(Logs, ABagWhoseDriverLeftNoStampsHasTheTimesOfItsLog) {
  const auto truth = test::hand();
  const std::string path = test::scratch("stamped.mcap");
  auto writer = McapWriter::create(path);
  ASSERT_TRUE(writer);
  for (const RawSample& s : truth) ASSERT_TRUE(writer->append(s));
  ASSERT_TRUE(writer->finish());
  std::ifstream stamped(path, std::ios::binary);
  std::string bytes((std::istreambuf_iterator<char>(stamped)), {});
  constexpr std::size_t kBefore = 12, kStamp = 8;  // the frame's name stands behind its length and the stamp
  for (std::size_t at = 0; (at = bytes.find("imu_link", at)) != std::string::npos; ++at)
    bytes.replace(at - kBefore, kStamp, kStamp, '\0');
  const auto imported = read(file("unstamped.mcap", bytes));
  ASSERT_EQ(imported.recording.size(), truth.size());
  EXPECT_EQ(imported.recording.t_ns[500], truth[500].t_ns - truth[0].t_ns);
  EXPECT_THAT(all(imported.reasons),
              HasSubstr("the stamps of /imu/data_raw do not advance; its times are those of the bag's log"));
}

}  // namespace
}  // namespace stillpoint::exchange
