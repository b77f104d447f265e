/// Payloads that cannot be deserialised, under the right type and topic: whoever reads them leaves them out, counts
/// nothing of them as a message, and hears the next good one.
#include <gtest/gtest.h>

#include <atomic>

#include "io/dds_publisher.h"
#include "io/dds_subscriber.h"
#include "tests/dds/dds_testing.h"
#include "tests/dds/malformed.h"

namespace stillpoint {
namespace {

using test::eventually;
using test::test_params;

TEST(Malformed, PayloadsOnEveryTopicAreLeftOutAndTheGoodOnesAfterThemAreHeard) {
  const io::DdsParams params = test_params();
  std::atomic<int> attitudes{0}, raw{0}, calibrations{0}, diagnostics{0};
  const auto subscriber =
      io::DdsSubscriber::create(params, {.attitude = [&](const AttitudeMessage&, std::int64_t) { ++attitudes; },
                                         .raw = [&](const RawSample&, std::int64_t) { ++raw; },
                                         .calibration = [&](const CalibrationMessage&) { ++calibrations; },
                                         .diagnostics = [&](const DiagnosticsMessage&) { ++diagnostics; }});
  ASSERT_TRUE(subscriber) << subscriber.error().message;
  test::MalformedPublisher stranger(params);
  ASSERT_TRUE(eventually([&] { return (*subscriber)->publishers() == 4; }));
  stranger.write_all();
  EXPECT_EQ(attitudes + raw + calibrations + diagnostics, 0);

  const auto publisher = io::DdsPublisher::create(params);
  ASSERT_TRUE(publisher) << publisher.error().message;
  std::uint64_t k = 0;
  EXPECT_TRUE(eventually([&] {
    (*publisher)->publish(test::attitude_message(++k));
    (*publisher)->publish_raw(test::raw_sample(k), 0);
    (*publisher)->publish_calibration(test::calibration_message());
    (*publisher)->publish_diagnostics(test::diagnostics_message());
    return attitudes > 5 && raw > 5 && calibrations > 0 && diagnostics > 0;
  }));
}

}  // namespace
}  // namespace stillpoint
