#include "apps/stillpointd/outlet.h"

namespace stillpoint::app {
namespace {

class LocalOutlet : public Outlet {
 public:
  explicit LocalOutlet(std::unique_ptr<io::DdsPublisher> publisher) : publisher_(std::move(publisher)) {}
  bool publish(const AttitudeMessage& message) noexcept override { return publisher_->publish(message); }
  void publish_raw(const RawSample& sample, std::int64_t t_arrival_ns) override {
    publisher_->publish_raw(sample, t_arrival_ns);
  }
  void publish_imu(const io::Ros2Sample& sample) override { publisher_->publish_imu(sample); }
  void publish_calibration(const CalibrationMessage& message) override { publisher_->publish_calibration(message); }
  void publish_diagnostics(const DiagnosticsMessage& message) override { publisher_->publish_diagnostics(message); }
  OutletReport report() override {
    return {publisher_->attitude_subscribers(), publisher_->neighbours(), publisher_->refused_datagrams()};
  }
  void wait_for_acknowledgements(double timeout_s) override { publisher_->wait_for_acknowledgements(timeout_s); }

 private:
  std::unique_ptr<io::DdsPublisher> publisher_;
};

}  // namespace

Result<std::unique_ptr<Outlet>> publish_in_this_process(const io::DdsParams& params) {
  auto made = io::DdsPublisher::create(params);
  if (!made) return tl::unexpected(made.error());
  return std::make_unique<LocalOutlet>(std::move(*made));
}

}  // namespace stillpoint::app
