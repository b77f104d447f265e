/// The daemon's side of DDS. Two threads use it: the sensor thread calls publish(AttitudeMessage), the slow thread all
/// the rest. Why the hot topic is best effort and the others have a participant of their own:
/// docs/decisions/060-dds.md.
#pragma once
#include <cstdint>
#include <memory>

#include "core/attitude_message.h"
#include "core/result.h"
#include "io/dds_neighbours.h"
#include "io/dds_params.h"

namespace stillpoint::io {

/// One sample as the ROS 2 topics show it: all in the axes of the body.
struct Ros2Sample {
  const AttitudeMessage& attitude;
  const CalibratedSample& calibrated;
  const RawSample& raw;
  const ReadingCovariances& covariances;
};

class DdsPublisher {
 public:
  /// Fails with 78 for values that make no sense, 69 when no participant can be created.
  [[nodiscard]] static Result<std::unique_ptr<DdsPublisher>> create(const DdsParams& params);
  ~DdsPublisher();
  DdsPublisher(const DdsPublisher&) = delete;
  DdsPublisher& operator=(const DdsPublisher&) = delete;

  /// Sensor thread. Stamps t_publish_ns and writes, best effort. Allocates nothing, waits for no subscriber.
  /// False: Fast DDS refused the write and the message is lost.
  bool publish(const AttitudeMessage& message) noexcept;

  // Slow thread. False: refused, or the topic is switched off.
  bool publish_raw(const RawSample& sample, std::int64_t t_arrival_ns);
  bool publish_calibration(const CalibrationMessage& message);
  bool publish_diagnostics(const DiagnosticsMessage& message);  ///< also as rt/diagnostics
  /// rt/imu/data, and what else ROS 2 programs look for: imu/data_raw, imu/mag and imu/temperature where measured.
  bool publish_imu(const Ros2Sample& sample);

  /// Subscribers of the attitude now matched. Any thread.
  [[nodiscard]] int attitude_subscribers() const;
  /// What other programs do on the attitude's topic. Any thread.
  [[nodiscard]] Neighbours neighbours() const;
  /// Datagrams so far that were kept from Fast DDS. Any thread.
  [[nodiscard]] RefusedDatagrams refused_datagrams() const;
  /// Before the end: waits until every reliable message so far has been acknowledged, and 0.2 s for subscribers of the
  /// attitude to read the last ones. False: the time was up. Slow thread.
  bool wait_for_acknowledgements(double timeout_s);

 private:
  struct Impl;
  explicit DdsPublisher(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace stillpoint::io
