#include "apps/stillpointd/wire.h"

#include <chrono>
#include <exception>

#include "io/dds_addresses.h"
#include "pipeline/clock.h"

namespace stillpoint::app {
namespace {

constexpr auto kLook = std::chrono::milliseconds(20);  // for an outlet that has died
constexpr std::int64_t kTryAgain_ns = 1'000'000'000;
constexpr const char* kWire = "dds";

/// Fast DDS throws where the machine refuses threads, memory or files.
Result<std::unique_ptr<Outlet>> make(const io::DdsParams& params) {
  try {
    return params.own_process ? publish_in_own_process(params) : publish_in_this_process(params);
  } catch (const std::exception& e) {
    return fail(ErrorKind::kUnavailable, std::string("dds: the machine refuses what a participant needs: ") + e.what() +
                                             "; raise the limits of threads (ulimit -u, TasksMax=), files (ulimit -n, "
                                             "LimitNOFILE=) or memory");
  }
}

}  // namespace

Wire::Wire(io::DdsParams params, std::shared_ptr<Troubles> troubles)
    : params_(std::move(params)), troubles_(std::move(troubles)) {}

Wire::~Wire() {
  thread_.request_stop();
  asked_.notify_all();
  if (thread_.joinable()) thread_.join();
  put_in(nullptr);
}

Result<void> Wire::start() {
  if (const auto faults = io::check(params_); !faults.empty())
    return fail(ErrorKind::kBadConfig, "dds: " + faults.front());
  try_to_make();
  thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
  return {};
}

void Wire::use(const io::DdsParams& params) {
  const std::lock_guard lock(mutex_);
  params_ = params;
  renew_ = true;
  asked_.notify_all();
}

void Wire::try_to_make() {
  io::DdsParams params;
  {
    const std::lock_guard lock(mutex_);
    params = params_;
    renew_ = false;
    addresses_ = io::local_addresses();
    tried_ns_ = monotonic_ns();
  }
  put_in(nullptr);  // before its successor: the two would take each other for strangers on one topic
  auto made = make(params);
  troubles_->set(kWire, made ? "" : "nothing is published yet: " + made.error().message);
  if (made) put_in(std::move(*made));
}

void Wire::put_in(std::unique_ptr<Outlet> made) {
  std::unique_ptr<Outlet> old;
  {
    const std::lock_guard lock(mutex_);
    old = std::exchange(owned_, std::move(made));
    if (owned_ && calibration_) owned_->publish_calibration(*calibration_);
    live_.store(owned_.get());
  }
  // Whoever enters from here on sees the new one; who is inside is waited for.
  while (old && sensor_inside_.load()) pipeline::sleep_until_ns(monotonic_ns() + 50'000);
}

/// A participant on all interfaces has joined those that were there when it was made.
bool Wire::must_be_made() {
  if (renew_) return true;
  if (owned_) {
    if (const std::string why = owned_->ended(); !why.empty()) {
      troubles_->set(kWire, why + "; it is started anew");
      return true;
    }
  }
  if (monotonic_ns() - tried_ns_ < kTryAgain_ns) return false;
  tried_ns_ = monotonic_ns();
  return !owned_ || (params_.interface == "any" && io::local_addresses() != addresses_);
}

void Wire::run(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    {
      std::unique_lock lock(mutex_);
      asked_.wait_for(lock, stop, kLook, [this] { return renew_; });
      if (stop.stop_requested()) return;
      if (!must_be_made()) continue;
    }
    try_to_make();
  }
}

bool Wire::publish(const AttitudeMessage& message) noexcept {
  sensor_inside_.store(true);
  Outlet* const publisher = live_.load();
  const bool written = publisher != nullptr && publisher->publish(message);
  sensor_inside_.store(false, std::memory_order_release);
  return written;
}

void Wire::publish_raw(const RawSample& sample, std::int64_t t_arrival_ns) {
  with([&](Outlet& o) { o.publish_raw(sample, t_arrival_ns); });
}

void Wire::publish_imu(const io::Ros2Sample& sample) {
  with([&](Outlet& o) { o.publish_imu(sample); });
}

void Wire::publish_calibration(CalibrationMessage message) {
  const std::lock_guard lock(mutex_);
  if (owned_) owned_->publish_calibration(message);
  calibration_ = std::move(message);
}

void Wire::publish_diagnostics(const DiagnosticsMessage& message) {
  with([&](Outlet& o) { o.publish_diagnostics(message); });
}

OutletReport Wire::report() {
  OutletReport out;
  with([&](Outlet& o) { out = o.report(); });
  return out;
}

void Wire::wait_for_acknowledgements(double timeout_s) {
  with([&](Outlet& o) { o.wait_for_acknowledgements(timeout_s); });
}

}  // namespace stillpoint::app
