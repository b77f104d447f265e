/// The daemon's attitude as another process receives it over DDS, against `stillpoint estimate` over the same
/// recording.
#pragma once
#include <bit>
#include <cstdlib>
#include <iostream>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "io/dds_subscriber.h"
#include "tests/apps/apps_testing.h"
#include "tests/dds/dds_testing.h"

namespace stillpoint::test {

/// The twelve numbers of a row, as bits: quaternion w x y z, three sigmas, three biases, rest flag, time in ns.
using RowBits = std::array<std::uint64_t, 12>;

inline RowBits row_bits(const std::string& line) {
  RowBits bits{};
  const char* at = line.c_str();
  char* end = nullptr;
  const long long seconds = std::strtoll(at, &end, 10);
  const long long ns = std::strtoll(end + 1, &end, 10);
  bits[11] = static_cast<std::uint64_t>(seconds * 1'000'000'000 + ns);
  for (std::size_t i = 0; i < 11; ++i) bits[i] = std::bit_cast<std::uint64_t>(std::strtod(end + 1, &end));
  return bits;
}

inline RowBits row_bits(const AttitudeMessage& m) {
  const auto& q = m.q_world_body_xyzw;
  const std::array<double, 11> values{q[3],
                                      q[0],
                                      q[1],
                                      q[2],
                                      m.sigma_rpy_rad[0],
                                      m.sigma_rpy_rad[1],
                                      m.sigma_rpy_rad[2],
                                      m.gyro_bias_radps[0],
                                      m.gyro_bias_radps[1],
                                      m.gyro_bias_radps[2],
                                      m.at_rest ? 1.0 : 0.0};
  RowBits bits{};
  for (std::size_t i = 0; i < values.size(); ++i) bits[i] = std::bit_cast<std::uint64_t>(values[i]);
  bits[11] = static_cast<std::uint64_t>(m.t_ns);
  return bits;
}

struct Received {
  std::mutex mutex;
  std::map<std::uint64_t, RowBits> rows;  ///< by time
  std::size_t messages = 0;
};

/// Of the rows sent how many did not come, and where the first and the last of them was. One is missing at least.
inline std::string missing(const std::map<std::uint64_t, RowBits>& sent, const std::map<std::uint64_t, RowBits>& came) {
  std::vector<std::size_t> rows;
  for (std::size_t row = 0; const auto& one : sent) {
    if (!came.contains(one.first)) rows.push_back(row);
    ++row;
  }
  return std::to_string(rows.size()) + " of " + std::to_string(sent.size()) + " rows are missing, row " +
         std::to_string(rows.front()) + " to row " + std::to_string(rows.back());
}

/// Share of the rows received. Fails the test on any difference, and on any message that `estimate` does not have.
inline double share_received_bit_for_bit(double speed) {
  const ScratchFolder scratch;
  const std::string config = scratch / "daemon.yaml";
  const io::DdsParams dds = test_params();
  write_file(config, "source: {kind: recording, file: " + handheld() + ", speed: " + std::to_string(speed) +
                         "}\ndds: {domain: " + std::to_string(dds.domain) + ", ros2: false}\n");
  EXPECT_EQ(run(std::string(STILLPOINT) + " estimate --config " + config + " --recording " + handheld() + " --output " +
                    (scratch / "attitude.csv"),
                scratch / "estimate.log"),
            0);
  std::map<std::uint64_t, RowBits> offline;
  std::ifstream csv(scratch / "attitude.csv");
  std::string line;
  std::getline(csv, line);  // the header
  while (std::getline(csv, line)) offline.emplace(row_bits(line)[11], row_bits(line));

  Received received;
  io::DdsHandlers handlers;
  handlers.attitude = [&received](const AttitudeMessage& m, std::int64_t) {
    const std::scoped_lock lock(received.mutex);
    ++received.messages;
    received.rows.emplace(static_cast<std::uint64_t>(m.t_ns), row_bits(m));
  };
  const auto subscriber = io::DdsSubscriber::create(dds, handlers);
  EXPECT_TRUE(subscriber.has_value());
  EXPECT_EQ(run(std::string(STILLPOINTD) + " --config " + config + " --wait-for-subscribers 1", scratch / "daemon.log"),
            0)
      << read_file(scratch / "daemon.log");
  std::this_thread::sleep_for(std::chrono::milliseconds(200));  // what is still on its way

  const std::scoped_lock lock(received.mutex);
  std::size_t different = 0;
  for (const auto& [time, row] : received.rows) {
    const auto found = offline.find(time);
    if (found == offline.end() || found->second != row) ++different;
  }
  EXPECT_EQ(different, 0U) << "of " << received.rows.size();
  EXPECT_EQ(received.messages, received.rows.size()) << "a message came twice";
  EXPECT_GT(offline.size(), 13'000U);
  if (received.rows.size() < offline.size())  // lost on the way, or refused or not written: the daemon knows
    std::cout << read_file(scratch / "daemon.log") << missing(offline, received.rows) << std::endl;
  return static_cast<double>(received.rows.size()) / static_cast<double>(offline.size());
}

}  // namespace stillpoint::test
