/// What the wire brings is judged before it is used: any writer of our types may have written it.
#include "io/dds_convert.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/dds/dds_testing.h"

namespace stillpoint::io {
namespace {

constexpr std::int64_t kNever_ns = std::numeric_limits<std::int64_t>::min();

TEST(Convert, AttitudesAndReadingsOfATimeThatNoClockHasAreLeftOut) {
  const AttitudeMessage good = test::attitude_message(1);
  for (auto AttitudeMessage::*const time :
       {&AttitudeMessage::t_ns, &AttitudeMessage::t_arrival_ns, &AttitudeMessage::t_publish_ns}) {
    AttitudeMessage sent = good, received;
    msg::Attitude wire;
    to_wire(sent, wire);
    EXPECT_TRUE(from_wire(wire, received));
    sent.*time = kNever_ns;
    to_wire(sent, wire);
    EXPECT_FALSE(from_wire(wire, received)) << "its latency would not fit into a number";
  }
  RawSample reading;
  msg::RawImu wire;
  to_wire(test::raw_sample(1), 0, wire);
  EXPECT_TRUE(from_wire(wire, reading));
  to_wire(test::raw_sample(1), kNever_ns, wire);
  EXPECT_FALSE(from_wire(wire, reading));
}

}  // namespace
}  // namespace stillpoint::io
