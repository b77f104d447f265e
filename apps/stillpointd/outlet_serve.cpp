#include <signal.h>
#include <sys/prctl.h>
#include <sys/socket.h>

#include <array>
#include <thread>

#include "apps/stillpointd/outlet.h"
#include "apps/stillpointd/wire_packet.h"
#include "core/clock.h"

namespace stillpoint::app {
namespace {

constexpr std::int64_t kReportPeriod_ns = 200'000'000;

/// Bytes of the next packet; none: the daemon is gone.
std::span<const std::byte> receive(int from, std::span<std::byte> room) {
  ssize_t n = 0;
  do n = recv(from, room.data(), room.size(), 0);
  while (n < 0 && errno == EINTR);
  return n > 0 ? std::span<const std::byte>(room.data(), static_cast<std::size_t>(n)) : std::span<const std::byte>();
}

void answer(int to, const std::string& why_not, const OutletReport& report) {
  PacketWriter packet(PacketKind::kSettings);
  packet.put(why_not);
  packet.put(report.attitude_subscribers);
  packet.put(report.neighbours);
  packet.put(report.datagrams);
  send(to, packet.bytes().data(), packet.bytes().size(), MSG_DONTWAIT | MSG_NOSIGNAL);
}

void publish_attitudes(int from, Outlet& outlet) {
  prctl(PR_SET_NAME, "wire attitude");
  AttitudeMessage message;
  while (receive(from, std::as_writable_bytes(std::span(&message, 1))).size() == sizeof message)
    outlet.publish(message);
}

void publish_other(PacketReader& packet, Outlet& outlet) {
  switch (packet.kind()) {
    case PacketKind::kSettings:
      return;
    case PacketKind::kRaw: {
      const auto p = packet.get<RawPacket>();
      return outlet.publish_raw(p.sample, p.t_arrival_ns);
    }
    case PacketKind::kRos2: {
      const auto p = packet.get<Ros2Packet>();
      return outlet.publish_imu({p.attitude, p.calibrated, p.raw, p.covariances});
    }
    case PacketKind::kCalibration:
      return outlet.publish_calibration(packet.get<CalibrationMessage>());
    case PacketKind::kDiagnostics:
      return outlet.publish_diagnostics(packet.get<DiagnosticsMessage>());
    case PacketKind::kAcknowledge:
      return outlet.wait_for_acknowledgements(packet.get<double>());
  }
}

}  // namespace

int serve_as_wire(int attitudes, int others) {
  for (const int number : {SIGTERM, SIGINT, SIGHUP}) signal(number, SIG_IGN);  // the daemon ends it, by closing
  static std::array<std::byte, 65536> room;
  PacketReader settings(receive(others, room));
  auto made = publish_in_this_process(settings.get<io::DdsParams>());
  if (!made) {
    answer(others, made.error().message, {});
    return static_cast<int>(made.error().kind);
  }
  Outlet& outlet = **made;
  answer(others, "", outlet.report());
  std::jthread hot([&] { publish_attitudes(attitudes, outlet); });
  std::int64_t next_report_ns = monotonic_ns();
  for (auto bytes = receive(others, room); !bytes.empty(); bytes = receive(others, room)) {
    PacketReader packet(bytes);
    publish_other(packet, outlet);
    if (monotonic_ns() < next_report_ns) continue;
    answer(others, "", outlet.report());
    next_report_ns = monotonic_ns() + kReportPeriod_ns;
  }
  return 0;
}

}  // namespace stillpoint::app
