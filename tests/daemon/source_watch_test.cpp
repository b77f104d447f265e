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

TEST_F(SourceWatchTest, TellsInWhichUnitATimeBeyondAllTimesLikelyIs) {
  sources::SourceReport now;
  const auto told = [&](double time, double unit_ns) {
    SourceWatch fresh(report_);
    ++now.times_refused;
    now.refused_time = time;
    now.refused_time_unit_ns = unit_ns;
    report_->store(now);
    const auto lines = fresh.news({});
    EXPECT_EQ("source: " + std::to_string(now.times_refused) + " " + fresh.trouble(), lines.at(0));
    return fresh.trouble();
  };
  EXPECT_EQ(told(1.7e18, 1e9),
            "rows are refused: the line's time 'time_s' = 1.7e+18 lies beyond 146 years; likely in ns: name the column "
            "time_ns");
  EXPECT_THAT(told(1.7e15, 1e6), testing::HasSubstr("'time_ms' = 1.7e+15 lies beyond 146 years; likely in us: name"));
  EXPECT_THAT(told(-1.7e12, 1e9), testing::HasSubstr("likely in ms: name the column time_ms"));
  EXPECT_THAT(told(1e20, 1e3), testing::HasSubstr("send a time since the start, or no time"));
}

TEST_F(SourceWatchTest, TellsOfRefusedTimesOnceAndIsInTroubleWhileTheyCome) {
  sources::SourceReport now;
  now.link = LinkState::kThere;
  const auto news_at = [&](std::uint64_t refused) {
    now.times_refused = refused;
    report_->store(now);
    return watch_.news({}).size();
  };
  news_at(0);
  EXPECT_EQ(news_at(1), 1U);
  EXPECT_EQ(news_at(2), 0U);
  EXPECT_NE(watch_.trouble(), "");
  EXPECT_EQ(news_at(2), 0U);
  EXPECT_EQ(watch_.trouble(), "");
  EXPECT_EQ(news_at(10), 1U);
}

TEST_F(SourceWatchTest, TellsOfReadingsThatWereLostOnTheirWay) {
  sources::SourceReport now;
  now.lost = 3;
  report_->store(now);
  EXPECT_THAT(watch_.news({}), ElementsAre("source: 3 readings so far were lost on their way, by the sender's count"));
  now.lost = 29;
  report_->store(now);
  EXPECT_THAT(watch_.news({}), IsEmpty());
  now.lost = 30;
  report_->store(now);
  EXPECT_EQ(watch_.news({}).size(), 1U);
}

TEST_F(SourceWatchTest, SaysWhatDamagedLinesLookLikeAndWhatTheHeaderLacks) {
  sources::SourceReport now;
  now.malformed = 1;
  now.refused = sources::ShortText("1,5;2,5");
  now.look = sources::LineLook::kDecimalCommas;
  now.header_faults = sources::ShortText("the header line lacks 'gx'");
  report_->store(now);
  EXPECT_THAT(watch_.news({}),
              ElementsAre("source: the header line lacks 'gx'",
                          "source: 1 damaged lines or frames so far, the last '1,5;2,5'; it looks like decimal commas: "
                          "write numbers with a point, as 9.81"));
  EXPECT_THAT(watch_.news({}), IsEmpty());
}

}  // namespace
}  // namespace stillpoint::app
