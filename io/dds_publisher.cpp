#include "io/dds_publisher.h"

#include <stillpoint_idl/ros2PubSubTypes.h>
#include <stillpoint_idl/stillpointPubSubTypes.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <exception>
#include <string_view>
#include <thread>
#include <vector>

#include "core/clock.h"
#include "io/dds_convert.h"
#include "io/dds_entities.h"

namespace stillpoint::io {
namespace {

using Code = eprosima::fastrtps::types::ReturnCode_t;

// RIHS01 hashes of the ROS 2 message definitions (REP-2011); ROS 2 from Iron on looks for them in the writer's
// USER_DATA.
constexpr std::string_view kImuHash = "7d9a00ff131080897a5ec7e26e315954b8eae3353c3f995c55faf71574000b5b";
constexpr std::string_view kMagneticFieldHash = "e80f32f56a20486c9923008fc1a1db07bbb273cbbf6a5b3bfa00835ee00e4dff";
constexpr std::string_view kDiagnosticArrayHash = "5a8a36efb05fb25070fa0fb3810290c0e6cd4862b54a8fb975a1ee8dc55a333e";
constexpr std::string_view kTemperatureHash = "72514a14126ab9f8a9abec974c78e5610a367b59db5da355ff1fb982d5bad4b8";
constexpr int kRos2Depth = 10;  // the depth of rmw's default profile

/// CLOCK_REALTIME of an instant of CLOCK_MONOTONIC: ROS 2 stamps are in wall time. 0 means now.
std::int64_t realtime_of(std::int64_t t_monotonic_ns) {
  const std::int64_t now_ns = clock_ns(CLOCK_REALTIME);
  return t_monotonic_ns == 0 ? now_ns : now_ns - (monotonic_ns() - t_monotonic_ns);
}

dds::DataWriterQos ros2_writer_qos(std::string_view hash) {
  dds::DataWriterQos qos = reliable_writer_qos(kRos2Depth, false);
  const std::string text = "typehash=RIHS01_" + std::string(hash) + ";";
  qos.user_data().data_vec(std::vector<eprosima::fastrtps::rtps::octet>(text.begin(), text.end()));
  return qos;
}

/// A writer whose messages serve nobody but the readers of the moment: without one the work is left out.
class Ros2Writer {
 public:
  dds::DataWriter* writer = nullptr;  ///< null: not published

  /// Looks at most every 20 ms, as looking takes a lock.
  bool is_wanted(std::int64_t now_ns) {
    constexpr std::int64_t kLookAgain_ns = 20'000'000;
    if (writer == nullptr) return false;
    if (now_ns - looked_ns_ < kLookAgain_ns) return wanted_;
    looked_ns_ = now_ns;
    dds::PublicationMatchedStatus status;
    writer->get_publication_matched_status(status);
    return wanted_ = status.current_count > 0;
  }

 private:
  std::int64_t looked_ns_ = 0;
  bool wanted_ = false;
};

}  // namespace

struct DdsPublisher::Impl {
  DdsParams params;
  std::unique_ptr<DdsEntities> hot, slow;  // two participants: what blocks inside one does not reach the other
  bool loan = false;
  dds::DataWriter* attitude = nullptr;
  dds::DataWriter* raw = nullptr;
  dds::DataWriter* calibration = nullptr;
  dds::DataWriter* diagnostics = nullptr;
  Ros2Writer imu, imu_raw, mag, temperature;
  dds::DataWriter* ros2_diagnostics = nullptr;
  // Kept between writes, so that the hot one is never constructed and the slow ones keep their strings' memory.
  msg::Attitude attitude_message;
  msg::RawImu raw_message;
  msg::CalibrationState calibration_message;
  msg::Diagnostics diagnostics_message;
  sensor_msgs::msg::Imu imu_message;
  sensor_msgs::msg::MagneticField mag_message;
  sensor_msgs::msg::Temperature temperature_message;
  diagnostic_msgs::msg::DiagnosticArray ros2_diagnostics_message;

  Result<void> create_writers();
};

Result<void> DdsPublisher::Impl::create_writers() {
  Result<void> done;
  const auto make = [&done](DdsEntities& in, const std::string& topic, dds::TopicDataType* type,
                            const dds::DataWriterQos& qos, dds::DataWriter*& writer) {
    const dds::TypeSupport support(type);
    if (!done) return;
    const auto made = in.writer(topic, support, qos);
    if (made)
      writer = *made;
    else
      done = tl::unexpected(made.error());
  };
  make(*hot, params.attitude_topic, new msg::AttitudePubSubType, attitude_writer_qos(params.transport), attitude);
  make(*slow, params.calibration_topic, new msg::CalibrationStatePubSubType, reliable_writer_qos(1, true), calibration);
  make(*slow, params.diagnostics_topic, new msg::DiagnosticsPubSubType, reliable_writer_qos(1, true), diagnostics);
  if (!params.raw_topic.empty())
    make(*slow, params.raw_topic, new msg::RawImuPubSubType, reliable_writer_qos(kRawDepth, false), raw);
  if (!params.ros2) return done;
  const std::string prefix = "rt/" + (params.ros2_namespace.empty() ? "" : params.ros2_namespace + "/");
  make(*slow, prefix + "imu/data", new sensor_msgs::msg::ImuPubSubType, ros2_writer_qos(kImuHash), imu.writer);
  if (params.ros2_readings) {
    make(*slow, prefix + "imu/data_raw", new sensor_msgs::msg::ImuPubSubType, ros2_writer_qos(kImuHash),
         imu_raw.writer);
    make(*slow, prefix + "imu/mag", new sensor_msgs::msg::MagneticFieldPubSubType, ros2_writer_qos(kMagneticFieldHash),
         mag.writer);
    make(*slow, prefix + "imu/temperature", new sensor_msgs::msg::TemperaturePubSubType,
         ros2_writer_qos(kTemperatureHash), temperature.writer);
  }
  // REP-107: one topic for all of a machine, so no namespace.
  make(*slow, "rt/diagnostics", new diagnostic_msgs::msg::DiagnosticArrayPubSubType,
       ros2_writer_qos(kDiagnosticArrayHash), ros2_diagnostics);
  return done;
}

DdsPublisher::DdsPublisher(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
DdsPublisher::~DdsPublisher() = default;

Result<std::unique_ptr<DdsPublisher>> DdsPublisher::create(const DdsParams& asked) {
  const DdsParams params = in_namespace(asked);
  auto impl = std::make_unique<Impl>();
  impl->params = params;
  impl->loan = params.transport == "data_sharing";
  auto watch = std::make_unique<NeighbourWatch>(params.attitude_topic, msg::AttitudePubSubType().getName());
  auto hot = DdsEntities::create(params, params.transport, "stillpointd", std::move(watch));
  if (!hot) return tl::unexpected(hot.error());
  auto slow = DdsEntities::create(params, "udp", "stillpointd/slow");
  if (!slow) return tl::unexpected(slow.error());
  impl->hot = std::move(*hot);
  impl->slow = std::move(*slow);
  if (auto made = impl->create_writers(); !made) return tl::unexpected(made.error());
  return std::unique_ptr<DdsPublisher>(new DdsPublisher(std::move(impl)));
}

bool DdsPublisher::publish(const AttitudeMessage& message) noexcept {
  msg::Attitude& own = impl_->attitude_message;
  to_wire(message, own);
  void* out = &own;
  // Fast DDS lends memory that lies four bytes off an eight-byte boundary: copied into, never used as an object.
  if (impl_->loan && impl_->attitude->loan_sample(out) != Code::RETCODE_OK) return false;
  own.t_publish_ns(monotonic_ns());
  if (impl_->loan) std::memcpy(out, static_cast<const void*>(&own), sizeof own);
  // Fast DDS guards what it shares between processes by a lock with a time limit of 1 s: where a reader was killed or
  // stopped inside, the write throws. That sample is lost, the publisher is not.
  try {
    if (impl_->attitude->write(out)) return true;
  } catch (const std::exception&) {
  }
  if (impl_->loan) impl_->attitude->discard_loan(out);
  return false;
}

bool DdsPublisher::publish_raw(const RawSample& sample, std::int64_t t_arrival_ns) {
  if (impl_->raw == nullptr) return false;
  to_wire(sample, t_arrival_ns, impl_->raw_message);
  return impl_->raw->write(&impl_->raw_message);
}

bool DdsPublisher::publish_calibration(const CalibrationMessage& message) {
  to_wire(message, impl_->calibration_message);
  return impl_->calibration->write(&impl_->calibration_message);
}

bool DdsPublisher::publish_diagnostics(const DiagnosticsMessage& message) {
  const std::int64_t t_ns = monotonic_ns();
  to_wire(message, impl_->diagnostics_message);
  impl_->diagnostics_message.t_publish_ns(t_ns);
  const bool written = impl_->diagnostics->write(&impl_->diagnostics_message);
  if (impl_->ros2_diagnostics == nullptr) return written;
  to_ros2(message, realtime_of(t_ns), impl_->ros2_diagnostics_message);
  return impl_->ros2_diagnostics->write(&impl_->ros2_diagnostics_message) && written;
}

bool DdsPublisher::publish_imu(const Ros2Sample& sample) {
  Impl& i = *impl_;
  const std::int64_t now_ns = monotonic_ns();
  const Ros2Header header{realtime_of(sample.attitude.t_arrival_ns), i.params.frame_id};
  bool written = true;
  if (i.imu.is_wanted(now_ns)) {
    to_ros2(sample.attitude, sample.calibrated, sample.covariances, header, i.imu_message);
    written = i.imu.writer->write(&i.imu_message);
  }
  if (i.imu_raw.is_wanted(now_ns)) {
    to_ros2_raw(sample.raw, sample.covariances, header, i.imu_message);
    written = i.imu_raw.writer->write(&i.imu_message) && written;
  }
  if (sample.calibrated.holds(kMag) && i.mag.is_wanted(now_ns)) {
    to_ros2(sample.calibrated, sample.covariances, header, i.mag_message);
    written = i.mag.writer->write(&i.mag_message) && written;
  }
  if (sample.raw.holds(kTemp) && i.temperature.is_wanted(now_ns)) {
    to_ros2(sample.raw.temp_degC, header, i.temperature_message);
    written = i.temperature.writer->write(&i.temperature_message) && written;
  }
  return written;
}

int DdsPublisher::attitude_subscribers() const {
  dds::PublicationMatchedStatus status;
  impl_->attitude->get_publication_matched_status(status);
  return status.current_count;
}

Neighbours DdsPublisher::neighbours() const { return impl_->hot->neighbours(); }

RefusedDatagrams DdsPublisher::refused_datagrams() const {
  RefusedDatagrams sum;
  for (const DdsEntities* one : {impl_->hot.get(), impl_->slow.get()}) {
    sum.malformed += one->gate().malformed;
    sum.off_host += one->gate().off_host;
    sum.flooded += one->gate().flooded;
  }
  return sum;
}

bool DdsPublisher::wait_for_acknowledgements(double timeout_s) {
  const auto end_ns = monotonic_ns() + static_cast<std::int64_t>(1e9 * timeout_s);
  bool all = true;
  for (auto* writer : {impl_->raw, impl_->calibration, impl_->diagnostics, impl_->imu.writer, impl_->imu_raw.writer,
                       impl_->mag.writer, impl_->temperature.writer, impl_->ros2_diagnostics}) {
    if (writer == nullptr) continue;
    const auto left_ns = std::max<std::int64_t>(0, end_ns - monotonic_ns());
    const eprosima::fastrtps::Duration_t left(static_cast<std::int32_t>(left_ns / 1'000'000'000),
                                              static_cast<std::uint32_t>(left_ns % 1'000'000'000));
    all = writer->wait_for_acknowledgments(left) == Code::RETCODE_OK && all;
  }
  // Nobody acknowledges an attitude. The notice of departure comes on a socket of its own: a busy reader that sees it
  // first drops what still waits.
  constexpr auto kUntilRead = std::chrono::milliseconds(200);
  if (attitude_subscribers() > 0) std::this_thread::sleep_for(kUntilRead);
  return all;
}

}  // namespace stillpoint::io
