/// One device of the kernel's IIO subsystem. All of libiio (0.24) is behind this file and iio_device.cpp.
#pragma once
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/result.h"
#include "io/source_config.h"
#include "sources/iio_values.h"
#include "sources/reading.h"

struct iio_context;
struct iio_device;
struct iio_channel;
struct iio_buffer;

namespace stillpoint::sources {

struct IioContextEnd {
  void operator()(iio_context* context) const noexcept;
};
using IioContext = std::unique_ptr<iio_context, IioContextEnd>;

/// Fails (69) with what the system says and what to do.
[[nodiscard]] Result<IioContext> open_iio(const std::string& uri);

class IioDevice {
 public:
  /// The devices of a context with an accelerometer, a gyroscope or a magnetometer of three axes, or with a channel of
  /// one that is unscaled().
  [[nodiscard]] static std::vector<IioDevice> all(iio_context& context);

  [[nodiscard]] const std::string& name() const noexcept { return name_; }
  /// "iio:device0": no two of a context have the same, as they may the same name.
  [[nodiscard]] std::string id() const;
  [[nodiscard]] std::uint8_t parts() const noexcept { return parts_; }
  /// A channel of motion of which the driver does not tell the scale or the offset that it has; empty: it tells all. A
  /// thermometer of that kind is left out.
  [[nodiscard]] const std::string& unscaled() const noexcept { return unscaled_; }
  /// Samples can be streamed by the kernel; otherwise the values are read one by one.
  [[nodiscard]] bool can_stream() const noexcept { return can_stream_; }
  [[nodiscard]] bool has_timestamps() const noexcept { return timestamp_ != nullptr; }
  [[nodiscard]] bool streams() const noexcept { return buffer_ != nullptr; }
  /// 0 where the driver does not say.
  [[nodiscard]] double rate_hz() const;
  /// One step of a reading of that part, in our unit.
  [[nodiscard]] double step_of(SamplePart part) const noexcept;

  /// Sets rate, clock and trigger, and begins to stream. In words why it cannot: then the values are polled.
  std::string start(const io::IioParams& params);
  using Take = std::function<void(const Reading&)>;
  /// Streaming: waits for a block and hands its scans on. Polling: one reading. Negative errno on failure.
  int read(const Take& take);
  /// Ends a wait in `read`, from any thread.
  void cancel() noexcept;

 private:
  struct Channel {
    iio_channel* handle = nullptr;
    IioChannelKind kind;
    IioScale scale;
    IioElement element;
  };
  struct BufferEnd {
    void operator()(iio_buffer* buffer) const noexcept;
  };

  explicit IioDevice(iio_device* device);
  void add(iio_channel* channel);
  void keep_whole_triads();
  [[nodiscard]] std::optional<Mat3> mount_of(const Channel& channel) const;
  void set_rate(double rate_hz) const;
  void put(const Channel& channel, double value, Reading& out) const noexcept;
  void finish(Reading& reading) const noexcept;
  int read_block(const Take& take);
  int poll(const Take& take);

  iio_device* device_;
  std::string name_, unscaled_;
  std::vector<Channel> channels_;
  iio_channel* timestamp_ = nullptr;
  std::uint8_t parts_ = 0;
  bool can_stream_ = false;
  std::optional<Mat3> acc_mount_, gyr_mount_, mag_mount_;
  std::unique_ptr<iio_buffer, BufferEnd> buffer_;
};

}  // namespace stillpoint::sources
