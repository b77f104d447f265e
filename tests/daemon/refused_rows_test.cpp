/// When the daemon says that stamps do not advance, and when that is over.
#include "apps/stillpointd/refused_rows.h"

#include <gmock/gmock.h>

namespace stillpoint::app {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

struct Told {
  RefusedRows rows;
  pipeline::GuardCounts counts;

  std::string after(std::uint64_t more, std::uint64_t refused) {
    counts.rows += more;
    counts.out_of_time += refused;
    return rows.news(counts);
  }
};

TEST(RefusedRows, AreToldOnceWithTheirShareAndWhatToDo) {
  Told told;
  EXPECT_THAT(told.after(1000, 5), IsEmpty());
  EXPECT_THAT(told.rows.trouble(), IsEmpty());
  EXPECT_THAT(told.after(500, 400), HasSubstr("80 % of the rows are refused, as their stamps do not advance"));
  EXPECT_TRUE(told.rows.most());
  EXPECT_THAT(told.after(500, 450), IsEmpty());
  EXPECT_THAT(told.rows.trouble(), HasSubstr("90 %"));
  EXPECT_THAT(told.after(500, 40), IsEmpty()) << "fewer, but not over";
  EXPECT_FALSE(told.rows.most());
  EXPECT_THAT(told.after(500, 0), HasSubstr("advance again"));
  EXPECT_THAT(told.rows.trouble(), IsEmpty());
}

TEST(RefusedRows, ASensorThatSendsEachRowTwiceIsToldButServes) {
  Told told;
  EXPECT_THAT(told.after(201, 101), HasSubstr("50 %"));
  EXPECT_FALSE(told.rows.most());
}

TEST(RefusedRows, AClockThatIsSetBackIsNoNewsHoweverSlowTheRowsCome) {
  Told told;
  for (int s = 0; s < 30; ++s) EXPECT_THAT(told.after(10, s == 12 ? 7 : 0), IsEmpty()) << s;
}

}  // namespace
}  // namespace stillpoint::app
