/// The daemon's way out: an outlet, as far as there is one. Where the network or its address is not there yet, the
/// outlet's process has died, or other settings are asked for, a thread of its own makes it, again and again, and the
/// sensor thread never waits.
#pragma once
#include <atomic>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "apps/stillpointd/outlet.h"
#include "apps/stillpointd/troubles.h"

namespace stillpoint::app {

class Wire {
 public:
  Wire(io::DdsParams params, std::shared_ptr<Troubles> troubles);
  ~Wire();
  Wire(const Wire&) = delete;
  Wire& operator=(const Wire&) = delete;

  /// The first try, and from then on the thread. Fails for values that make no sense (78); all else is tried again.
  [[nodiscard]] Result<void> start();
  /// Publishes with other settings from now on. Subscribers see one publisher go and another come.
  void use(const io::DdsParams& params);

  /// Sensor thread. Wait-free but for the write itself. False: nobody can receive it, or the write failed.
  bool publish(const AttitudeMessage& message) noexcept;

  // Slow thread.
  void publish_raw(const RawSample& sample, std::int64_t t_arrival_ns);
  void publish_imu(const io::Ros2Sample& sample);
  void publish_calibration(CalibrationMessage message);  ///< kept, for a publisher that comes later
  void publish_diagnostics(const DiagnosticsMessage& message);

  /// Any thread but the sensor's.
  [[nodiscard]] OutletReport report();
  void wait_for_acknowledgements(double timeout_s);

 private:
  void try_to_make();
  void put_in(std::unique_ptr<Outlet> made);
  void run(const std::stop_token& stop);
  [[nodiscard]] bool must_be_made();
  /// Calls with the publisher while no other takes its place; nothing where there is none.
  template <class Use>
  void with(const Use& use) {
    const std::lock_guard lock(mutex_);
    if (owned_) use(*owned_);
  }

  std::mutex mutex_;  // of all below but the two atomics; never taken by the sensor thread
  std::condition_variable_any asked_;
  io::DdsParams params_;
  bool renew_ = false;
  std::unique_ptr<Outlet> owned_;
  std::optional<CalibrationMessage> calibration_;
  std::vector<std::uint32_t> addresses_;
  std::int64_t tried_ns_ = 0;
  std::shared_ptr<Troubles> troubles_;
  std::atomic<Outlet*> live_{nullptr};
  std::atomic<bool> sensor_inside_{false};
  std::jthread thread_;  // last: ends before what it uses
};

}  // namespace stillpoint::app
