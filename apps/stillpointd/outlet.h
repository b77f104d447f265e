/// Where the daemon's messages go out: a publisher in this process, or one in a process of its own.
#pragma once
#include <cstdint>
#include <memory>
#include <string>

#include "core/result.h"
#include "io/dds_publisher.h"

namespace stillpoint::app {

/// What the far side of the publisher looks like.
struct OutletReport {
  int attitude_subscribers = 0;
  io::Neighbours neighbours{};
  io::RefusedDatagrams datagrams{};
};

class Outlet {
 public:
  virtual ~Outlet() = default;
  /// Sensor thread: wait-free but for the write itself.
  virtual bool publish(const AttitudeMessage& message) noexcept = 0;
  // Slow thread.
  virtual void publish_raw(const RawSample& sample, std::int64_t t_arrival_ns) = 0;
  virtual void publish_imu(const io::Ros2Sample& sample) = 0;
  virtual void publish_calibration(const CalibrationMessage& message) = 0;
  virtual void publish_diagnostics(const DiagnosticsMessage& message) = 0;
  virtual OutletReport report() = 0;
  virtual void wait_for_acknowledgements(double timeout_s) = 0;
  /// Why it serves no longer; empty: it does.
  virtual std::string ended() { return {}; }
};

/// Fails as DdsPublisher::create does.
[[nodiscard]] Result<std::unique_ptr<Outlet>> publish_in_this_process(const io::DdsParams& params);
[[nodiscard]] Result<std::unique_ptr<Outlet>> publish_in_own_process(const io::DdsParams& params);
/// What the program does that publish_in_own_process starts: publishes what comes in by these two sockets until the
/// other side closes them. The exit code.
[[nodiscard]] int serve_as_wire(int attitudes, int others);

}  // namespace stillpoint::app
