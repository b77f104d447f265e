#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <thread>

#include "apps/stillpointd/outlet.h"
#include "apps/stillpointd/wire_packet.h"
#include "core/clock.h"

extern char** environ;

namespace stillpoint::app {
namespace {

constexpr int kBuffer_bytes = 1 << 20;  // a second of attitudes at 4 kHz, while the other process starts anew
constexpr double kStart_s = 5.0;        // by then it has said that it is up, or why not
constexpr double kEnd_s = 2.0;

/// A pair of connected sockets that keep packets apart; the far end goes to the other process.
struct SocketPair {
  int near = -1, far = -1;
  bool open() {
    std::array<int, 2> ends{};
    if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends.data()) != 0) return false;
    near = ends[0];
    far = ends[1];
    for (const int end : ends) setsockopt(end, SOL_SOCKET, SO_SNDBUF, &kBuffer_bytes, sizeof kBuffer_bytes);
    return true;
  }
  void close_far() {
    if (far >= 0) close(std::exchange(far, -1));
  }
  void close_near() {
    if (near >= 0) close(std::exchange(near, -1));
  }
  ~SocketPair() {
    close_far();
    close_near();
  }
};

class ProcessOutlet : public Outlet {
 public:
  ~ProcessOutlet() override {
    attitudes_.close_near();  // it ends by itself when nothing more can come
    others_.close_near();
    for (const std::int64_t end_ns = monotonic_ns() + static_cast<std::int64_t>(1e9 * kEnd_s);
         pid_ > 0 && ended().empty() && monotonic_ns() < end_ns;)
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    if (pid_ > 0) {
      kill(pid_, SIGKILL);
      waitpid(pid_, nullptr, 0);
    }
  }

  Result<void> start(const io::DdsParams& params) {
    if (!attitudes_.open() || !others_.open() || !spawn())
      return fail(ErrorKind::kUnavailable, "dds: no process can be started for it");
    attitudes_.close_far();
    others_.close_far();
    PacketWriter settings(PacketKind::kSettings);
    settings.put(params);
    send_other(settings, 0);
    pollfd answer{others_.near, POLLIN, 0};
    poll(&answer, 1, static_cast<int>(1e3 * kStart_s));
    std::string refusal = "dds: the process of its own does not answer";
    if (receive_report(&refusal)) return {};
    return fail(ErrorKind::kUnavailable, refusal);
  }

  bool publish(const AttitudeMessage& message) noexcept override {
    return send(attitudes_.near, &message, sizeof message, MSG_DONTWAIT | MSG_NOSIGNAL) == sizeof message;
  }
  void publish_raw(const RawSample& sample, std::int64_t t_arrival_ns) override {
    put(PacketKind::kRaw, RawPacket{sample, t_arrival_ns});
  }
  void publish_imu(const io::Ros2Sample& s) override {
    put(PacketKind::kRos2, Ros2Packet{s.attitude, s.calibrated, s.raw, s.covariances});
  }
  void publish_calibration(const CalibrationMessage& message) override { put(PacketKind::kCalibration, message); }
  void publish_diagnostics(const DiagnosticsMessage& message) override { put(PacketKind::kDiagnostics, message); }
  OutletReport report() override {
    while (receive_report(nullptr)) continue;
    return report_;
  }
  void wait_for_acknowledgements(double timeout_s) override { put(PacketKind::kAcknowledge, timeout_s); }

  std::string ended() override {
    int status = 0;
    if (pid_ <= 0 || waitpid(pid_, &status, WNOHANG) != pid_) return {};
    pid_ = -1;
    return WIFSIGNALED(status) ? fmt::format("the process of DDS was ended by {}", strsignal(WTERMSIG(status)))
                               : fmt::format("the process of DDS ended with code {}", WEXITSTATUS(status));
  }

 private:
  bool spawn() {
    const std::string ends = fmt::format("{},{}", kAttitudes, kOthers);
    std::string program = "/proc/self/exe", option = "--wire";
    std::string value = ends;
    std::array<char*, 4> argv{program.data(), option.data(), value.data(), nullptr};
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, attitudes_.far, kAttitudes);
    posix_spawn_file_actions_adddup2(&actions, others_.far, kOthers);
    const int error = posix_spawn(&pid_, program.c_str(), &actions, nullptr, argv.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    if (error != 0) pid_ = -1;
    return error == 0;
  }
  template <class T>
  void put(PacketKind kind, const T& value) {
    PacketWriter packet(kind);
    packet.put(value);
    send_other(packet, MSG_DONTWAIT);
  }
  void send_other(const PacketWriter& packet, int flags) {
    send(others_.near, packet.bytes().data(), packet.bytes().size(), flags | MSG_NOSIGNAL);
  }
  /// False: none is there, or it says why it cannot serve.
  bool receive_report(std::string* refusal) {
    std::array<std::byte, 4096> bytes{};
    const ssize_t n = recv(others_.near, bytes.data(), bytes.size(), MSG_DONTWAIT);
    if (n <= 0) return false;
    PacketReader packet({bytes.data(), static_cast<std::size_t>(n)});
    const auto why_not = packet.get<std::string>();
    if (!why_not.empty()) {
      if (refusal != nullptr) *refusal = why_not;
      return false;
    }
    packet.get(report_.attitude_subscribers);
    packet.get(report_.neighbours);
    packet.get(report_.datagrams);
    return true;
  }

  // Beyond what the daemon may have open and did not mark to be closed.
  static constexpr int kAttitudes = 198, kOthers = 199;
  SocketPair attitudes_, others_;
  pid_t pid_ = -1;
  OutletReport report_;
};

}  // namespace

Result<std::unique_ptr<Outlet>> publish_in_own_process(const io::DdsParams& params) {
  auto outlet = std::make_unique<ProcessOutlet>();
  if (const auto started = outlet->start(params); !started) return tl::unexpected(started.error());
  return outlet;
}

}  // namespace stillpoint::app
