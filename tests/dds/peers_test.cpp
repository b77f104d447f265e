#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <mutex>

#include "io/dds_publisher.h"
#include "io/dds_subscriber.h"
#include "tests/dds/dds_testing.h"
#include "tests/dds/process.h"

namespace stillpoint {
namespace {

using test::attitude_message;
using test::eventually;
using test::Process;
using test::test_params;
using Clock = std::chrono::steady_clock;

std::string domain() { return std::to_string(test_params().domain); }

TEST(DdsPeers, ALateSubscriberGetsTheLatestCalibrationAndDiagnosticsAtOnce) {
  auto publisher = io::DdsPublisher::create(test_params());
  ASSERT_TRUE(publisher) << publisher.error().message;
  CalibrationMessage old = test::calibration_message();
  old.snapshot.version = 1;
  ASSERT_TRUE((*publisher)->publish_calibration(old));
  ASSERT_TRUE((*publisher)->publish_calibration(test::calibration_message()));
  ASSERT_TRUE((*publisher)->publish_diagnostics(test::diagnostics_message()));

  std::mutex mutex;
  std::vector<CalibrationMessage> calibrations;
  std::vector<DiagnosticsMessage> diagnostics;
  const auto late = io::DdsSubscriber::create(test_params(), {.calibration =
                                                                  [&](const CalibrationMessage& m) {
                                                                    const std::lock_guard lock(mutex);
                                                                    calibrations.push_back(m);
                                                                  },
                                                              .diagnostics =
                                                                  [&](const DiagnosticsMessage& m) {
                                                                    const std::lock_guard lock(mutex);
                                                                    diagnostics.push_back(m);
                                                                  }});
  ASSERT_TRUE(late) << late.error().message;
  ASSERT_TRUE(eventually([&] {
    const std::lock_guard lock(mutex);
    return !calibrations.empty() && !diagnostics.empty();
  }));
  const std::lock_guard lock(mutex);
  const auto expected = test::calibration_message();
  ASSERT_EQ(calibrations.size(), 1U) << "the calibration before the latest is history";
  EXPECT_EQ(calibrations[0].snapshot.version, expected.snapshot.version);
  EXPECT_EQ(calibrations[0].reasons, expected.reasons);
  EXPECT_EQ(calibrations[0].sensor_id, expected.sensor_id);
  EXPECT_EQ(calibrations[0].snapshot.mag.bias_covariance, expected.snapshot.mag.bias_covariance);
  EXPECT_EQ(calibrations[0].snapshot.gyr.matrix, expected.snapshot.gyr.matrix);
  EXPECT_EQ(calibrations[0].snapshot.gyr.status, CalibrationStatus::kNotObservable);
  EXPECT_EQ(calibrations[0].snapshot.acc.bias_per_K2, expected.snapshot.acc.bias_per_K2);
  EXPECT_EQ(calibrations[0].snapshot.acc.windows, expected.snapshot.acc.windows);
  EXPECT_EQ(diagnostics[0].latency_counts, test::diagnostics_message().latency_counts);
  EXPECT_EQ(diagnostics[0].latency_max_ns, test::diagnostics_message().latency_max_ns);
  EXPECT_EQ(diagnostics[0].source, test::diagnostics_message().source);
  EXPECT_EQ(diagnostics[0].missing, test::diagnostics_message().missing);
  EXPECT_EQ(diagnostics[0].health.gyr.fault, Fault::kStuck);
  EXPECT_EQ(diagnostics[0].health.gyr.since_ns, 12'000'000'000);
  EXPECT_EQ(diagnostics[0].health.gyr.evidence, 3.5);
  EXPECT_EQ(diagnostics[0].health.temp.state, Health::kAbsent);
  EXPECT_EQ(diagnostics[0].not_finite, 3U);
  EXPECT_EQ(diagnostics[0].datagrams_flooded, 6U);
  EXPECT_EQ(diagnostics[0].last_refusal, "turning at 0.6 deg/s");
}

TEST(DdsPeers, TheReliableReadingsOfAnotherProcessAllArriveInOrder) {
  constexpr std::uint64_t kSamples = 2000;  // 2 s at 1 kHz
  std::mutex mutex;
  std::vector<RawSample> received;
  const auto subscriber = io::DdsSubscriber::create(test_params(), {.raw = [&](const RawSample& s, std::int64_t) {
                                                      const std::lock_guard lock(mutex);
                                                      received.push_back(s);
                                                    }});
  ASSERT_TRUE(subscriber) << subscriber.error().message;
  Process peer({DDS_PEER, "publish", domain(), "udp", "2.5", "1000"});
  ASSERT_TRUE(peer.started());
  EXPECT_EQ(peer.wait(), 0);
  const std::lock_guard lock(mutex);
  ASSERT_FALSE(received.empty());
  // The match takes a moment; from the first one on, nothing may be missing.
  const std::uint64_t first = received.front().sequence;
  EXPECT_GT(received.size() + first, kSamples);
  for (std::size_t i = 0; i < received.size(); ++i) {
    const RawSample expected = test::raw_sample(first + i);
    ASSERT_EQ(received[i].sequence, first + i);
    ASSERT_EQ(received[i].t_ns, expected.t_ns);
    ASSERT_EQ(received[i].acc_mps2, expected.acc_mps2);
    ASSERT_EQ(received[i].mag_uT, expected.mag_uT);
    ASSERT_EQ(received[i].has, expected.has);
  }
}

TEST(DdsPeers, TwentySubscribersOnOneMachineAllGetTheAttitude) {
  auto publisher = io::DdsPublisher::create(test_params());
  ASSERT_TRUE(publisher) << publisher.error().message;
  constexpr std::size_t kSubscribers = 20;
  std::array<std::atomic<int>, kSubscribers> received{};
  std::vector<std::unique_ptr<io::DdsSubscriber>> subscribers;
  for (auto& count : received) {
    auto subscriber = io::DdsSubscriber::create(
        test_params(), {.attitude = [&count](const AttitudeMessage&, std::int64_t) { ++count; }});
    ASSERT_TRUE(subscriber) << subscriber.error().message;
    subscribers.push_back(std::move(*subscriber));
  }
  ASSERT_TRUE(eventually([&] { return (*publisher)->attitude_subscribers() == static_cast<int>(kSubscribers); }))
      << (*publisher)->attitude_subscribers() << " matched";
  std::uint64_t k = 0;
  EXPECT_TRUE(eventually([&] {
    (*publisher)->publish(attitude_message(k++));
    return std::all_of(received.begin(), received.end(), [](const auto& n) { return n > 0; });
  }));
}

/// Seconds that 3000 writes took.
double time_to_publish(io::DdsPublisher& publisher) {
  const auto start = Clock::now();
  for (std::uint64_t k = 0; k < 3000; ++k) publisher.publish(attitude_message(k));
  return std::chrono::duration<double>(Clock::now() - start).count();
}

class BrokenSubscriber : public testing::TestWithParam<const char*> {};

TEST_P(BrokenSubscriber, StoppedOrKilledDoesNotDelayThePublisher) {
  auto publisher = io::DdsPublisher::create(test_params(GetParam()));
  ASSERT_TRUE(publisher) << publisher.error().message;
  const auto start_subscriber = [&] {
    auto peer = std::make_unique<Process>(std::vector<std::string>{DDS_PEER, "subscribe", domain(), GetParam(), "30"});
    EXPECT_TRUE(eventually([&] { return (*publisher)->attitude_subscribers() == 1; }));
    peer->some_output();  // it has matched too
    return peer;
  };
  auto peer = start_subscriber();
  time_to_publish(**publisher);
  const double healthy_s = time_to_publish(**publisher);
  peer->send(SIGSTOP);
  const double stopped_s = time_to_publish(**publisher);
  peer->send(SIGKILL);
  const double killed_s = time_to_publish(**publisher);
  peer.reset();
  // A stopped reader costs less or the same; ten times leaves room for a machine that is busy with other tests. A
  // writer that waits for its reader takes 100 ms a write, thousands of times as long. Through shared memory a reader
  // may be caught inside Fast DDS's lock: then each write waits 1 s for it, until the reader's lease has ended.
  const double caught_in_lock_s = std::string(GetParam()) == "udp" ? 0.0 : 20.0;
  EXPECT_LT(stopped_s, 10 * healthy_s + caught_in_lock_s);
  EXPECT_LT(killed_s, 10 * healthy_s + caught_in_lock_s);

  // The next subscriber is served too: over shm once the lease of the killed one (5 s) has ended.
  Process next({DDS_PEER, "subscribe", domain(), GetParam(), "20"});
  std::uint64_t k = 0;
  std::string last;
  EXPECT_TRUE(eventually([&] {
    (*publisher)->publish(attitude_message(k++));
    if (k % 40 != 0 || (*publisher)->attitude_subscribers() == 0) return false;
    last = next.some_output();
    return !last.empty() && last != "0\n";
  })) << "last said: "
      << last;
}

INSTANTIATE_TEST_SUITE_P(Transports, BrokenSubscriber, testing::Values("udp", "shm", "data_sharing"),
                         [](const auto& test) { return std::string(test.param); });

TEST(DdsPeers, WhatWasWrittenLastReachesASubscriberThatIsBusy) {
  constexpr std::uint64_t kMessages = 50;
  for (int round = 0; round < 5; ++round) {
    auto publisher = io::DdsPublisher::create(test_params());
    ASSERT_TRUE(publisher) << publisher.error().message;
    Process peer({DDS_PEER, "subscribe", domain(), "udp", "30"});
    ASSERT_TRUE(eventually([&] { return (*publisher)->attitude_subscribers() == 1; }));
    ASSERT_FALSE(peer.some_output().empty());  // it has matched too
    peer.send(SIGSTOP);
    for (std::uint64_t k = 0; k < kMessages; ++k) (*publisher)->publish(attitude_message(k));
    std::jthread goes_on([&] {
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
      peer.send(SIGCONT);
    });
    EXPECT_TRUE((*publisher)->wait_for_acknowledgements(1.0));
    publisher->reset();
    goes_on.join();
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    peer.send(SIGTERM);
    EXPECT_THAT(peer.output(), testing::EndsWith(std::to_string(kMessages) + "\n")) << "round " << round;
  }
}

TEST(DdsPeers, APublisherStartsBesideTheLeftoversOfAKilledOne) {
  for (const char* transport : {"shm", "data_sharing"}) {
    Process killed({DDS_PEER, "publish", domain(), transport, "30", "100"});
    Process reader({DDS_PEER, "subscribe", domain(), transport, "30"});
    ASSERT_FALSE(reader.some_output().empty());
    killed.send(SIGKILL);
    EXPECT_EQ(killed.wait(), 128 + SIGKILL);

    Process heir({DDS_PEER, "publish", domain(), transport, "30", "100"});
    std::atomic<int> received{0};
    const auto subscriber = io::DdsSubscriber::create(
        test_params(transport), {.attitude = [&](const AttitudeMessage&, std::int64_t) { ++received; }});
    ASSERT_TRUE(subscriber) << subscriber.error().message;
    EXPECT_TRUE(eventually([&] { return received > 10; })) << transport;
  }
}

}  // namespace
}  // namespace stillpoint
