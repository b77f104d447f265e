/// The other side: calls back for every message of one daemon. Used by `stillpoint watch` and `record`, the tests and
/// the benches.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>

#include "core/attitude_message.h"
#include "core/result.h"
#include "io/dds_params.h"

namespace stillpoint::io {

/// Called on a thread of Fast DDS, one topic's messages in order. A handler left empty: that topic is not subscribed.
/// t_receive_ns is CLOCK_MONOTONIC on entry.
struct DdsHandlers {
  std::function<void(const AttitudeMessage&, std::int64_t t_receive_ns)> attitude{};
  std::function<void(const RawSample&, std::int64_t t_arrival_ns)> raw{};
  std::function<void(const CalibrationMessage&)> calibration{};
  std::function<void(const DiagnosticsMessage&)> diagnostics{};
};

class DdsSubscriber {
 public:
  /// Fails as DdsPublisher::create does.
  [[nodiscard]] static Result<std::unique_ptr<DdsSubscriber>> create(const DdsParams& params, DdsHandlers handlers);
  ~DdsSubscriber();
  DdsSubscriber(const DdsSubscriber&) = delete;
  DdsSubscriber& operator=(const DdsSubscriber&) = delete;

  /// Publishers now matched, of all subscribed topics. Any thread.
  [[nodiscard]] int publishers() const;

 private:
  struct Impl;
  explicit DdsSubscriber(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace stillpoint::io
