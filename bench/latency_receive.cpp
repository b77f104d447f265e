/// The receiving process of bench/latency.
#include <arpa/inet.h>
#include <linux/futex.h>
#include <sched.h>
#include <stillpoint_idl/stillpointPubSubTypes.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstdio>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <thread>

#include "bench/latency_channels.h"
#include "bench/latency_wire.h"
#include "io/dds_entities.h"
#include "io/dds_subscriber.h"

namespace stillpoint::bench {
namespace {

constexpr std::size_t kMostReceipts = 1U << 20U;
constexpr std::int64_t kSilence_ns = 500'000'000;     // after the last message
constexpr std::int64_t kPatience_ns = 8'000'000'000;  // for the first one

/// Receipts, filled by one thread and counted by another.
class Receipts {
 public:
  Receipts() : receipts_(kMostReceipts) {}
  void add(std::uint64_t sequence, std::int64_t latency_ns) {
    const std::size_t n = count_.load(std::memory_order_relaxed);
    if (n == kMostReceipts) return;
    receipts_[n] = {sequence, latency_ns};
    count_.store(n + 1, std::memory_order_release);
  }
  [[nodiscard]] std::size_t count() const { return count_.load(std::memory_order_acquire); }
  void write() const { std::fwrite(receipts_.data(), sizeof(Receipt), count(), stdout); }

 private:
  std::vector<Receipt> receipts_;
  std::atomic<std::size_t> count_{0};
};

void say_ready(std::int32_t port) {
  std::fwrite(&port, sizeof port, 1, stdout);
  std::fflush(stdout);
}

/// For the channels whose receiving thread is not ours: until the messages have stopped.
void wait_for_silence(const Receipts& receipts) {
  std::int64_t last_change_ns = monotonic_ns();
  std::size_t seen = 0;
  while (monotonic_ns() - last_change_ns < (seen == 0 ? kPatience_ns : kSilence_ns)) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    if (receipts.count() == seen) continue;
    seen = receipts.count();
    last_change_ns = monotonic_ns();
  }
}

int receive_socket(Receipts& receipts) {
  const int s = socket(AF_INET, SOCK_DGRAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  if (s < 0 || bind(s, reinterpret_cast<sockaddr*>(&address), size) != 0) return 1;
  getsockname(s, reinterpret_cast<sockaddr*>(&address), &size);
  say_ready(ntohs(address.sin_port));
  const auto wait_at_most = [s](std::int64_t ns) {
    const timeval limit{ns / 1'000'000'000, (ns % 1'000'000'000) / 1000};
    setsockopt(s, SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit);
  };
  wait_at_most(kPatience_ns);
  Payload payload;
  while (recv(s, &payload, sizeof payload, 0) == static_cast<ssize_t>(sizeof payload)) {
    receipts.add(payload.sequence, monotonic_ns() - payload.due_ns);
    if (receipts.count() == 1) wait_at_most(kSilence_ns);
  }
  close(s);
  return 0;
}

int receive_futex(Receipts& receipts, int fd) {
  auto* shared = static_cast<SharedRing*>(mmap(nullptr, sizeof(SharedRing), PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0));
  if (shared == MAP_FAILED) return 1;
  say_ready(0);
  std::uint32_t tail = 0;
  while (true) {
    const std::uint32_t head = shared->head.load(std::memory_order_acquire);
    if (head == tail) {
      const std::int64_t ns = tail == 0 ? kPatience_ns : kSilence_ns;
      const timespec limit{ns / 1'000'000'000, ns % 1'000'000'000};
      if (syscall(SYS_futex, &shared->head, FUTEX_WAIT, tail, &limit, nullptr, 0) != 0 && errno == ETIMEDOUT) return 0;
      continue;
    }
    const Payload payload = shared->slots[tail % SharedRing::kSlots];
    receipts.add(payload.sequence, monotonic_ns() - payload.due_ns);
    ++tail;
  }
}

class RawListener : public io::dds::DataReaderListener {
 public:
  explicit RawListener(Receipts& receipts) : receipts_(receipts) {}
  void on_data_available(io::dds::DataReader* reader) override {
    const std::int64_t now_ns = monotonic_ns();
    io::dds::SampleInfo info;
    while (reader->take_next_sample(&message_, &info) == eprosima::fastrtps::types::ReturnCode_t::RETCODE_OK)
      if (info.valid_data) receipts_.add(message_.sample_number(), now_ns - message_.t_arrival_ns());
  }
  void on_subscription_matched(io::dds::DataReader*, const io::dds::SubscriptionMatchedStatus& status) override {
    matched = status.current_count > 0;
  }
  std::atomic<bool> matched{false};

 private:
  Receipts& receipts_;
  msg::Attitude message_;
};

int receive_fastdds(Receipts& receipts, const io::DdsParams& params) {
  auto entities = io::DdsEntities::create(params, params.transport, "bench receiver");
  if (!entities) return 1;
  RawListener listener(receipts);
  const io::dds::TypeSupport type(new msg::AttitudePubSubType);
  if (!(*entities)->reader(params.attitude_topic, type, io::attitude_reader_qos(params.transport), &listener)) return 1;
  for (int i = 0; i < 500 && !listener.matched; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  say_ready(0);
  wait_for_silence(receipts);
  (*entities)->stop();
  return 0;
}

int receive_daemon(Receipts& receipts, const io::DdsParams& params) {
  const auto subscriber =
      io::DdsSubscriber::create(params, {.attitude = [&receipts](const AttitudeMessage& m, std::int64_t t_receive_ns) {
                                  receipts.add(m.sequence, t_receive_ns - m.t_arrival_ns);
                                }});
  if (!subscriber) return 1;
  say_ready(0);  // the daemon starts now and may send before the match: the first messages are not judged
  wait_for_silence(receipts);
  return 0;
}

}  // namespace

bool schedule_this_thread(int core, int fifo_priority) {
  prctl(PR_SET_TIMERSLACK,
        1UL);  // as the daemon's threads: no floor is to wait longer than what is measured against it
  if (core >= 0) {
    cpu_set_t set;
    CPU_ZERO(&set);
    CPU_SET(static_cast<std::size_t>(core), &set);
    sched_setaffinity(0, sizeof set, &set);
  }
  if (fifo_priority <= 0) return false;
  sched_param param{};
  param.sched_priority = fifo_priority;
  return sched_setscheduler(0, SCHED_FIFO, &param) == 0;
}

int receive(const std::string& channel, int where) {
  Receipts receipts;
  io::DdsParams params;
  params.domain = where;
  params.transport = channel.substr(channel.find('/') + 1);
  int code = 64;
  if (channel == "udp_socket") code = receive_socket(receipts);
  if (channel == "shm_futex") code = receive_futex(receipts, where);
  if (channel.starts_with("fastdds/")) code = receive_fastdds(receipts, params);
  if (channel.starts_with("daemon/")) code = receive_daemon(receipts, params);
  receipts.write();
  return code;
}

}  // namespace stillpoint::bench
