/// What the log says of a source that comes, goes and stays away.
#include "apps/stillpointd/source_watch.h"

#include <gmock/gmock.h>

namespace stillpoint::app {
namespace {

using sources::LinkState;
using testing::ElementsAre;
using testing::IsEmpty;

class SourceWatchTest : public testing::Test {
 protected:
  std::vector<std::string> news_of(LinkState link, std::uint64_t failures, std::string_view error) {
    sources::SourceReport now;
    now.link = link;
    now.failures = failures;
    now.error = sources::ShortText(error);
    report_->store(now);
    return watch_.news({});
  }

  sources::ReportCell report_ = std::make_shared<SnapshotCell<sources::SourceReport>>();
  SourceWatch watch_{report_};
};

TEST_F(SourceWatchTest, TellsOnceWhyNothingCanBeOpened) {
  EXPECT_THAT(news_of(LinkState::kNeverThere, 1, "no device"), ElementsAre("source: no device; it is tried again"));
  EXPECT_THAT(news_of(LinkState::kNeverThere, 2, "no device"), IsEmpty());
  EXPECT_THAT(news_of(LinkState::kNeverThere, 3, "no right"), ElementsAre("source: no right; it is tried again"));
}

TEST_F(SourceWatchTest, TellsAfterALossWhatItToldBeforeTheFirstReading) {
  news_of(LinkState::kNeverThere, 1, "no device");
  EXPECT_THAT(news_of(LinkState::kThere, 1, "no device"), ElementsAre("source: there"));
  EXPECT_THAT(news_of(LinkState::kGone, 3, "no device"),
              ElementsAre("source: gone; it is waited for", "source: no device; it is tried again"));
  EXPECT_THAT(news_of(LinkState::kThere, 3, "no device"), ElementsAre("source: there again"));
}

TEST_F(SourceWatchTest, TellsAnErrorThatWasReadBeforeItsFailureWasCounted) {
  news_of(LinkState::kThere, 0, "");
  EXPECT_THAT(news_of(LinkState::kGone, 0, "pulled"), ElementsAre("source: gone; it is waited for"));
  EXPECT_THAT(news_of(LinkState::kGone, 1, "pulled"), ElementsAre("source: pulled; it is tried again"));
}

TEST_F(SourceWatchTest, ASensorThatWasThereIsGoneAndNotOneThatNeverCame) {
  news_of(LinkState::kNeverThere, 0, "");
  EXPECT_EQ(watch_.trouble(), "no sensor yet");
  news_of(LinkState::kThere, 0, "");
  EXPECT_EQ(watch_.trouble(), "");
  news_of(LinkState::kGone, 0, "");
  EXPECT_EQ(watch_.trouble(), "the sensor is gone; it is waited for");
}

TEST_F(SourceWatchTest, TellsEachTimeThatASenderBeganAnew) {
  sources::SourceReport now;
  report_->store(now);
  EXPECT_THAT(watch_.news({}), IsEmpty());
  now.began_anew = 1;
  now.away_ns = 3'000'000'000;
  report_->store(now);
  EXPECT_THAT(watch_.news({}), ElementsAre(testing::HasSubstr("began anew after 3.00 s without a reading (1 so far)")));
  EXPECT_THAT(watch_.news({}), IsEmpty());
}

TEST_F(SourceWatchTest, TellsOnceOfLinesThatEndWithACarriageReturnAlone) {
  sources::SourceReport now;
  now.returns_alone = true;
  report_->store(now);
  EXPECT_THAT(watch_.news({}),
              ElementsAre("source: lines end with a carriage return alone; end them with a line feed"));
  EXPECT_THAT(watch_.news({}), IsEmpty());
}

}  // namespace
}  // namespace stillpoint::app
