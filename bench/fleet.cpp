/// Discovery of a fleet on one machine: so many daemons' publishers, each in a namespace of its own, and so many
/// subscribers of each, in a network of their own. Printed is how long it takes until each subscriber has met its
/// daemon, and the datagrams sent for it, where everybody looks for everybody and where a discovery server tells them.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <fstream>
#include <memory>
#include <sstream>
#include <thread>
#include <vector>

#include "bench/arguments.h"
#include "core/clock.h"
#include "core/units.h"
#include "io/dds_publisher.h"
#include "io/dds_subscriber.h"
#include "pipeline/clock.h"
#include "tests/dds/discovery_server.h"
#include "tests/dds/network_namespace.h"

namespace {

using namespace stillpoint;

constexpr std::uint16_t kServerPort = 11811;
constexpr std::int64_t kLook_ns = 5'000'000;

struct Traffic {
  std::uint64_t datagrams = 0, bytes = 0;
};

/// Of this network since it was made: UDP datagrams sent (a multicast counts once), bytes sent over loopback.
Traffic traffic() {
  Traffic out;
  std::string line, word;
  std::ifstream protocols("/proc/thread-self/net/snmp");
  for (bool is_names = true; std::getline(protocols, line);) {
    if (!line.starts_with("Udp:")) continue;
    std::istringstream words(line);
    for (int k = 0; k < 5 && words >> word; ++k) continue;  // Udp: InDatagrams NoPorts InErrors OutDatagrams
    if (!is_names) out.datagrams = std::stoull(word);
    is_names = false;
  }
  std::ifstream devices("/proc/thread-self/net/dev");
  while (std::getline(devices, line)) {
    std::istringstream words(line);
    if (words >> word && word == "lo:") words >> out.bytes;  // received, which over loopback is what was sent
  }
  return out;
}

struct Size {
  int daemons = 0, subscribers_each = 1;
};

struct Fleet {
  std::vector<std::unique_ptr<io::DdsPublisher>> daemons;
  std::vector<std::unique_ptr<io::DdsSubscriber>> subscribers;

  [[nodiscard]] bool has_met() const {
    constexpr int kTopics = 3;
    const auto each = static_cast<int>(subscribers.size() / daemons.size());
    for (const auto& daemon : daemons)
      if (daemon->attitude_subscribers() != each) return false;
    for (const auto& subscriber : subscribers)
      if (subscriber->publishers() != kTopics) return false;
    return true;
  }
};

/// Throws where a participant cannot be made.
Fleet start(const Size& size, bool through_server) {
  Fleet fleet;
  io::DdsParams params;
  params.domain = 1;
  if (through_server) params.discovery_server = {fmt::format("127.0.0.1:{}", kServerPort)};
  for (int k = 0; k < size.daemons; ++k) {
    params.name_space = fmt::format("sensor{}", k);
    auto daemon = io::DdsPublisher::create(params);
    if (!daemon) throw std::runtime_error(daemon.error().message);
    fleet.daemons.push_back(std::move(*daemon));
    for (int j = 0; j < size.subscribers_each; ++j) {
      auto subscriber = io::DdsSubscriber::create(params, {.attitude = [](const AttitudeMessage&, std::int64_t) {},
                                                           .calibration = [](const CalibrationMessage&) {},
                                                           .diagnostics = [](const DiagnosticsMessage&) {}});
      if (!subscriber) throw std::runtime_error(subscriber.error().message);
      fleet.subscribers.push_back(std::move(*subscriber));
    }
  }
  return fleet;
}

/// One line of the table. False: not all have met within the limit.
bool measure(const Size& size, bool through_server, double limit_s, double rest_s) {
  std::unique_ptr<test::DiscoveryServer> server;
  if (through_server) server = std::make_unique<test::DiscoveryServer>(0, kServerPort);
  const Traffic before = traffic();
  const std::int64_t start_ns = monotonic_ns();
  const Fleet fleet = start(size, through_server);
  const std::int64_t all_started_ns = monotonic_ns();
  while (!fleet.has_met() && in_seconds(monotonic_ns() - all_started_ns) < limit_s)
    pipeline::sleep_until_ns(monotonic_ns() + kLook_ns);
  const std::int64_t met_ns = monotonic_ns();
  const Traffic met = traffic();
  const bool all = fleet.has_met();
  std::this_thread::sleep_for(std::chrono::duration<double>(rest_s));
  const Traffic rest = traffic();
  const auto seconds = [](std::int64_t from_ns, std::int64_t to_ns) { return in_seconds(to_ns - from_ns); };
  const double rested_s = seconds(met_ns, monotonic_ns());
  fmt::print("| {} + {} | {} | {:.1f} s | {} | {} | {:.0f} | {:.0f} kB |\n", size.daemons,
             size.daemons * size.subscribers_each, through_server ? "server" : "each other",
             seconds(start_ns, all_started_ns),
             all ? fmt::format("{:.1f} s", seconds(start_ns, met_ns)) : fmt::format("not {:.0f} s later", limit_s),
             met.datagrams - before.datagrams, static_cast<double>(rest.datagrams - met.datagrams) / rested_s,
             1e-3 * static_cast<double>(rest.bytes - met.bytes) / rested_s);
  std::fflush(stdout);
  return all;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App cli{"Time and datagrams of discovery, with and without a discovery server.", "fleet"};
  std::vector<int> sizes{2, 5, 10};
  int subscribers = 1;
  double rest_s = 10.0, limit_s = 60.0;
  std::string told_by = "both";
  cli.add_option("--sizes", sizes, "daemons")->check(CLI::Range(1, 60))->capture_default_str();
  cli.add_option("--subscribers", subscribers, "of each daemon")->check(CLI::Range(1, 10))->capture_default_str();
  cli.add_option("--told-by", told_by, "who tells whom there is")
      ->check(CLI::IsMember({"both", "server", "other"}))
      ->capture_default_str();
  cli.add_option("--limit", limit_s, "seconds after the last has started that the others are waited for")
      ->check(CLI::Range(1.0, 3600.0))
      ->capture_default_str();
  cli.add_option("--rest", rest_s, "seconds over which the datagrams after discovery are counted")
      ->check(CLI::Range(0.1, 600.0))
      ->capture_default_str();
  if (const auto code = bench::parse(cli, argc, argv)) return *code;
  const test::NetworkNamespace network;
  if (!network.ready()) return fmt::print(stderr, "fleet: needs root and `ip`, for a network of its own\n"), 69;
  fmt::print(
      "| daemons + subscribers | told by | all started | all met | datagrams until then | a second later | |\n"
      "|---|---|---|---|---|---|---|\n");
  bool all = true;
  try {
    for (const int size : sizes)
      for (const bool through_server : {false, true})
        if (told_by == "both" || (told_by == "server") == through_server)
          all = measure({size, subscribers}, through_server, limit_s, rest_s) && all;
  } catch (const std::exception& e) {
    return fmt::print(stderr, "fleet: {}\n", e.what()), 69;
  }
  return all ? 0 : 1;
}
