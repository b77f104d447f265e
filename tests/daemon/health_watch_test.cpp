/// What the log and `missing` say of sensors that fall silent.
#include "apps/stillpointd/health_watch.h"

#include <gmock/gmock.h>

namespace stillpoint::app {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

constexpr SensorHealth kSilent{Health::kAbsent, Fault::kAbsent, 8'000'000'000};

TEST(HealthWatch, NamesAMagnetometerAndAThermometerThatFallSilentAsLongAsTheyAre) {
  HealthWatch watch;
  EXPECT_THAT(watch.news({}), IsEmpty());
  EXPECT_EQ(watch.silent(), "");
  SensorsHealth now;
  now.mag = now.temp = kSilent;
  EXPECT_THAT(watch.news(now), ElementsAre("magnetometer: absent, no readings since t = 8.00 s",
                                           "thermometer: absent, no readings since t = 8.00 s"));
  EXPECT_THAT(watch.news(now), IsEmpty());
  EXPECT_EQ(watch.silent(),
            "magnetometer: absent, no readings since t = 8.00 s; thermometer: absent, no readings since t = 8.00 s");
  EXPECT_THAT(watch.news({}), ElementsAre("magnetometer: ok again", "thermometer: ok again"));
  EXPECT_EQ(watch.silent(), "");
}

TEST(HealthWatch, DoesNotMissAMagnetometerThatNeverSpokeButAnAccelerometer) {
  HealthWatch watch;
  EXPECT_THAT(watch.news(unheard()), ElementsAre("accelerometer: absent, no readings since t = 0.00 s",
                                                 "gyroscope: absent, no readings since t = 0.00 s"));
  EXPECT_THAT(watch.silent(), testing::Not(testing::HasSubstr("magnetometer")));
}

}  // namespace
}  // namespace stillpoint::app
