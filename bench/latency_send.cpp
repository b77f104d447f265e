/// The sending side of bench/latency.
#include <arpa/inet.h>
#include <fmt/format.h>
#include <linux/futex.h>
#include <stillpoint_idl/stillpointPubSubTypes.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <chrono>
#include <climits>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <thread>

#include "bench/latency_channels.h"
#include "bench/latency_wire.h"
#include "io/dds_entities.h"
#include "tests/dds/process.h"

namespace stillpoint::bench {
namespace {

using Send = std::function<void(std::uint64_t sequence, std::int64_t due_ns)>;
using Code = eprosima::fastrtps::types::ReturnCode_t;

/// Sends at the rate on a thread of its own, scheduled as the daemon's sensor thread is.
void send_paced(const CellSetup& setup, const Send& send) {
  std::thread([&] {
    schedule_this_thread(setup.send_core, setup.fifo_priority);
    const auto messages = static_cast<std::uint64_t>(setup.rate_hz * setup.seconds);
    const std::int64_t start_ns = monotonic_ns() + 10'000'000;
    for (std::uint64_t k = 0; k < messages; ++k) {
      const std::int64_t due_ns = start_ns + static_cast<std::int64_t>(1e9 * static_cast<double>(k) / setup.rate_hz);
      const timespec until{due_ns / 1'000'000'000, due_ns % 1'000'000'000};
      clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr);
      send(k, due_ns);
    }
  }).join();
}

std::vector<std::string> receiver_command(const CellSetup& setup, int where) {
  return {setup.self,
          "--receive",
          setup.channel,
          "--where",
          std::to_string(where),
          "--core",
          std::to_string(setup.receive_core),
          "--fifo",
          std::to_string(setup.fifo_priority)};
}

Result<std::int32_t> wait_until_ready(test::Process& receiver) {
  const std::string said = receiver.some_output();
  std::int32_t port = 0;
  if (said.size() < sizeof port) return fail(ErrorKind::kUnavailable, "the receiver did not start");
  std::memcpy(&port, said.data(), sizeof port);
  return port;
}

Result<std::vector<Receipt>> collect(test::Process& receiver) {
  const std::string bytes = receiver.output();
  if (receiver.wait() != 0) return fail(ErrorKind::kUnavailable, "the receiver failed");
  std::vector<Receipt> receipts(bytes.size() / sizeof(Receipt));
  std::memcpy(receipts.data(), bytes.data(), receipts.size() * sizeof(Receipt));
  return receipts;
}

Result<std::vector<Receipt>> run_socket(const CellSetup& setup) {
  test::Process receiver(receiver_command(setup, 0));
  const auto port = wait_until_ready(receiver);
  if (!port) return tl::unexpected(port.error());
  const int s = socket(AF_INET, SOCK_DGRAM, 0);
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  to.sin_port = htons(static_cast<std::uint16_t>(*port));
  send_paced(setup, [&](std::uint64_t sequence, std::int64_t due_ns) {
    const Payload payload{.sequence = sequence, .due_ns = due_ns, .rest = {}};
    sendto(s, &payload, sizeof payload, 0, reinterpret_cast<const sockaddr*>(&to), sizeof to);
  });
  close(s);
  return collect(receiver);
}

Result<std::vector<Receipt>> run_futex(const CellSetup& setup) {
  const int fd = memfd_create("stillpoint-latency", 0);
  if (fd < 0 || ftruncate(fd, sizeof(SharedRing)) != 0) return fail(ErrorKind::kUnavailable, "no shared memory");
  auto* shared = static_cast<SharedRing*>(mmap(nullptr, sizeof(SharedRing), PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0));
  test::Process receiver(receiver_command(setup, fd));
  if (const auto ready = wait_until_ready(receiver); !ready) return tl::unexpected(ready.error());
  send_paced(setup, [shared](std::uint64_t sequence, std::int64_t due_ns) {
    const std::uint32_t head = shared->head.load(std::memory_order_relaxed);
    shared->slots[head % SharedRing::kSlots] = {.sequence = sequence, .due_ns = due_ns, .rest = {}};
    shared->head.store(head + 1, std::memory_order_release);
    syscall(SYS_futex, &shared->head, FUTEX_WAKE, INT_MAX, nullptr, nullptr, 0);
  });
  munmap(shared, sizeof(SharedRing));
  close(fd);
  return collect(receiver);
}

Result<std::vector<Receipt>> run_fastdds(const CellSetup& setup, const io::DdsParams& params) {
  auto entities = io::DdsEntities::create(params, params.transport, "bench sender");
  if (!entities) return tl::unexpected(entities.error());
  const io::dds::TypeSupport type(new msg::AttitudePubSubType);
  const auto writer = (*entities)->writer(params.attitude_topic, type, io::attitude_writer_qos(params.transport));
  if (!writer) return tl::unexpected(writer.error());
  test::Process receiver(receiver_command(setup, params.domain));
  if (const auto ready = wait_until_ready(receiver); !ready) return tl::unexpected(ready.error());
  const bool loan = params.transport == "data_sharing";
  msg::Attitude own;
  send_paced(setup, [&](std::uint64_t sequence, std::int64_t due_ns) {
    void* message = &own;
    own.sample_number(sequence);
    own.t_arrival_ns(due_ns);
    if (loan) {
      if ((*writer)->loan_sample(message) != Code::RETCODE_OK) return;
      std::memcpy(message, static_cast<const void*>(&own), sizeof own);
    }
    (*writer)->write(message);
  });
  return collect(receiver);
}

/// What the daemon reads as its sensor: five seconds of rest, five of turning, noise by a formula.
void write_sensor_recording(const CellSetup& setup, const std::filesystem::path& path) {
  std::ofstream out(path);
  out << "time_ns,acc_x_mps2,acc_y_mps2,acc_z_mps2,gyr_x_radps,gyr_y_radps,gyr_z_radps,mag_x_uT,mag_y_uT,mag_z_uT,temp_"
         "degC\n";
  const auto rows = static_cast<int>(setup.rate_hz * setup.seconds);
  for (int k = 0; k < rows; ++k) {
    const double t_s = k / setup.rate_hz;
    const double noise = std::sin(12.9898 * k) * std::cos(78.233 * k);
    const double rate_radps = std::fmod(t_s, 10.0) < 5.0 ? 0.0 : 0.5;
    out << fmt::format("{},{:.6f},{:.6f},{:.6f},{:.6f},{:.6f},{:.6f},{:.4f},{:.4f},{:.4f},25.0\n",
                       static_cast<std::int64_t>(1e9 * t_s), 0.02 * noise, -0.02 * noise, 9.80665 + 0.01 * noise,
                       0.001 * noise, 0.002 * noise, rate_radps - 0.001 * noise, 0.2 * noise, 20.0,
                       -43.0 - 0.2 * noise);
  }
}

Result<std::vector<Receipt>> run_daemon(const CellSetup& setup, const io::DdsParams& params) {
  namespace fs = std::filesystem;
  const fs::path folder = fs::temp_directory_path() / fmt::format("stillpoint_latency_{}", getpid());
  fs::create_directories(folder);
  write_sensor_recording(setup, folder / "sensor.csv");
  std::ofstream(folder / "daemon.yaml") << fmt::format(
      "source: {{kind: recording, file: sensor.csv, speed: 1, at_end: stop}}\nsensor: {{id: bench}}\n"
      "dds: {{domain: {}, transport: {}}}\nthreads: {{sensor_core: {}, calibration_core: {}, fifo_priority: {}}}\n",
      params.domain, params.transport, setup.send_core, setup.receive_core, setup.fifo_priority);
  test::Process receiver(receiver_command(setup, params.domain));
  if (const auto ready = wait_until_ready(receiver); !ready) return tl::unexpected(ready.error());
  test::Process daemon({setup.daemon, "--config", folder / "daemon.yaml"}, folder / "log");
  auto receipts = collect(receiver);
  daemon.send(SIGTERM);
  const int code = daemon.wait();
  std::stringstream log;
  log << std::ifstream(folder / "log").rdbuf();
  fs::remove_all(folder);
  if (code != 0)
    return fail(ErrorKind::kUnavailable, fmt::format("{} ended with code {}:\n{}", setup.daemon, code, log.str()));
  return receipts;
}

}  // namespace

Result<std::vector<Receipt>> run_cell(const CellSetup& setup) {
  io::DdsParams params;
  params.domain = setup.domain;
  params.transport = setup.channel.substr(setup.channel.find('/') + 1);
  if (setup.channel == "shm_futex") return run_futex(setup);
  if (setup.channel == "udp_socket") return run_socket(setup);
  return setup.channel.starts_with("daemon/") ? run_daemon(setup, params) : run_fastdds(setup, params);
}

}  // namespace stillpoint::bench
