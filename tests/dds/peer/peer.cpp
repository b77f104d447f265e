/// The other process of the DDS tests: `dds_peer publish|subscribe DOMAIN TRANSPORT SECONDS [RATE_HZ]`. Ends by itself;
/// a subscriber that is terminated says goodbye.
#include <fmt/format.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <thread>

#include "io/dds_publisher.h"
#include "io/dds_subscriber.h"
#include "tests/dds/dds_testing.h"

namespace {

using namespace stillpoint;
using Clock = std::chrono::steady_clock;

int publish(const io::DdsParams& params, double seconds, double rate_hz) {
  auto publisher = io::DdsPublisher::create(params);
  if (!publisher) return std::fprintf(stderr, "%s\n", publisher.error().message.c_str()), 1;
  (*publisher)->publish_calibration(test::calibration_message());
  (*publisher)->publish_diagnostics(test::diagnostics_message());
  const auto start = Clock::now();
  for (std::uint64_t k = 0; std::chrono::duration<double>(Clock::now() - start).count() < seconds; ++k) {
    (*publisher)->publish(test::attitude_message(k));
    (*publisher)->publish_raw(test::raw_sample(k), 0);
    (*publisher)->publish_imu({test::attitude_message(k), {.has = kAcc | kGyr}, test::raw_sample(k), {}});
    std::this_thread::sleep_until(start + std::chrono::duration<double>(static_cast<double>(k + 1) / rate_hz));
  }
  return (*publisher)->wait_for_acknowledgements(2.0) ? 0 : 2;
}

volatile std::sig_atomic_t terminated = 0;

/// Says "ready" once matched, then how many attitudes came, each tenth of a second.
int subscribe(const io::DdsParams& params, double seconds) {
  std::atomic<std::uint64_t> received{0};
  const auto subscriber =
      io::DdsSubscriber::create(params, {.attitude = [&](const AttitudeMessage&, std::int64_t) { ++received; }});
  if (!subscriber) return std::fprintf(stderr, "%s\n", subscriber.error().message.c_str()), 1;
  std::signal(SIGTERM, [](int) { terminated = 1; });
  const auto start = Clock::now();
  while (terminated == 0 && std::chrono::duration<double>(Clock::now() - start).count() < seconds) {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    if ((*subscriber)->publishers() > 0) fmt::print("{}\n", received.load());
    std::fflush(stdout);
  }
  fmt::print("{}\n", received.load());
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 5) return std::fputs("dds_peer publish|subscribe DOMAIN TRANSPORT SECONDS [RATE_HZ]\n", stderr), 64;
  io::DdsParams params;
  params.domain = std::atoi(argv[2]);
  params.transport = argv[3];
  const double seconds = std::atof(argv[4]);
  return std::strcmp(argv[1], "publish") == 0 ? publish(params, seconds, argc > 5 ? std::atof(argv[5]) : 100.0)
                                              : subscribe(params, seconds);
}
