/// The ways from one process to another that bench/latency compares. Each sender and receiver does the least that its
/// way needs.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/result.h"

namespace stillpoint::bench {

/// daemon/T: stillpointd with a recording as its sensor, over transport T, into a DdsSubscriber.
/// fastdds/T: Fast DDS alone with the same type and the same quality of service.
/// udp_socket: one sendto and one recv of as many bytes. shm_futex: shared memory and one futex wake.
inline const std::vector<std::string> kChannels{
    "shm_futex",   "udp_socket", "fastdds/udp",          "daemon/udp",
    "fastdds/shm", "daemon/shm", "fastdds/data_sharing", "daemon/data_sharing"};

/// One received message.
struct Receipt {
  std::uint64_t sequence = 0;
  std::int64_t latency_ns = 0;  ///< from the instant the sample was due to the receiver's callback
};

struct CellSetup {
  std::string channel;
  double rate_hz = 1000.0;
  double seconds = 1.0;
  int domain = 1;
  int send_core = -1, receive_core = -1;  ///< -1: any
  int fifo_priority = 0;                  ///< 0: normal scheduling
  std::string daemon;                     ///< path of stillpointd
  std::string self;                       ///< path of this program, which is also the receiver
};

/// Runs one cell: starts the receiver, sends at the rate, returns what was received.
[[nodiscard]] Result<std::vector<Receipt>> run_cell(const CellSetup& setup);

/// The receiver's whole life, in its own process. `where` is the channel's address: a domain or a file descriptor.
/// Tells on standard output that it is ready, then, after half a second without a message, writes its receipts.
int receive(const std::string& channel, int where);

/// Pins the calling thread and asks for SCHED_FIFO; what the system refuses is left out. True: FIFO was granted.
bool schedule_this_thread(int core, int fifo_priority);

}  // namespace stillpoint::bench
