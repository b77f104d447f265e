#include "sources/iio_device.h"

#include <fmt/format.h>
#include <iio.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>

namespace stillpoint::sources {
namespace {

constexpr unsigned kTimeout_ms = 2000;
constexpr double kKept_s = 1.0;  ///< so long the kernel keeps what nobody fetches; what overflows it does not tell

std::string iio_reason(int code) {
  std::string text = std::strerror(code);
  if (code == EACCES || code == EPERM)
    text += "; a udev rule gives a group the right: SUBSYSTEM==\"iio\", GROUP=\"iio\", MODE=\"0660\" (docs/sources.md)";
  if (code == EBUSY) text += "; another program streams from it";
  return text;
}

std::string attribute(const iio_channel* channel, const char* name) {
  std::array<char, 512> text{};
  const auto n = iio_channel_attr_read(channel, name, text.data(), text.size() - 1);
  return n > 0 ? std::string(text.data()) : std::string();
}
std::string attribute(const iio_device* device, const char* name) {
  std::array<char, 512> text{};
  const auto n = iio_device_attr_read(device, name, text.data(), text.size() - 1);
  return n > 0 ? std::string(text.data()) : std::string();
}

/// Nothing where the driver has an offset or a scale and does not tell it: no reading has a unit without.
std::optional<IioScale> scale_of(const iio_channel* channel, double unit) {
  double offset = 0.0, scale = 1.0;
  const auto told = [channel](const char* name, double& value) {
    return iio_channel_find_attr(channel, name) == nullptr || iio_channel_attr_read_double(channel, name, &value) >= 0;
  };
  if (!told("offset", offset) || !told("scale", scale)) return std::nullopt;
  return IioScale{offset, scale * unit};
}

IioElement element_of(const iio_channel* channel) {
  const iio_data_format* f = iio_channel_get_data_format(channel);
  return {f->is_be, f->is_signed, f->bits, f->length, f->shift};
}

bool decodable(const iio_channel* channel) {
  const IioElement e = element_of(channel);
  return iio_channel_is_scan_element(channel) && iio_channel_get_data_format(channel)->repeat <= 1 && e.bits > 0 &&
         e.storage_bits % 8 == 0 && e.storage_bits <= 64 && e.bits + e.shift <= e.storage_bits;
}

}  // namespace

void IioContextEnd::operator()(iio_context* context) const noexcept { iio_context_destroy(context); }
void IioDevice::BufferEnd::operator()(iio_buffer* buffer) const noexcept { iio_buffer_destroy(buffer); }

Result<IioContext> open_iio(const std::string& uri) {
  std::string writable = uri;  // libiio 0.24 cuts the port off the caller's text, and crashes on a literal
  IioContext context(iio_create_context_from_uri(writable.data()));
  if (context == nullptr) {
    const int code = errno;
    const bool none = uri.starts_with("local") && (code == ENOENT || code == ENOSYS);
    return fail(ErrorKind::kUnavailable,
                fmt::format("IIO {}: {}", uri,
                            none ? "this kernel has no IIO device: is the driver loaded?" : iio_reason(code)));
  }
  iio_context_set_timeout(context.get(), kTimeout_ms);
  return context;
}

std::vector<IioDevice> IioDevice::all(iio_context& context) {
  std::vector<IioDevice> out;
  for (unsigned k = 0; k < iio_context_get_devices_count(&context); ++k) {
    IioDevice device(iio_context_get_device(&context, k));
    if ((device.parts_ & (kAcc | kGyr | kMag)) != 0 || !device.unscaled_.empty()) out.push_back(std::move(device));
  }
  return out;
}

IioDevice::IioDevice(iio_device* device) : device_(device) {
  const char* name = iio_device_get_name(device);
  name_ = name != nullptr ? name : iio_device_get_id(device);
  for (unsigned k = 0; k < iio_device_get_channels_count(device); ++k) add(iio_device_get_channel(device, k));
  keep_whole_triads();
  can_stream_ = !channels_.empty() &&
                std::all_of(channels_.begin(), channels_.end(), [](const Channel& c) { return decodable(c.handle); });
}

std::string IioDevice::id() const { return iio_device_get_id(device_); }

void IioDevice::add(iio_channel* channel) {
  if (iio_channel_is_output(channel)) return;
  if (std::strcmp(iio_channel_get_id(channel), "timestamp") == 0) {
    if (iio_channel_is_scan_element(channel)) timestamp_ = channel;
    return;
  }
  const auto kind = iio_channel_kind(iio_channel_get_id(channel));
  if (!kind) return;
  if (const auto scale = scale_of(channel, kind->unit))
    channels_.push_back({channel, *kind, *scale, element_of(channel)});
  else if (kind->part != kTemp && unscaled_.empty())
    unscaled_ = iio_channel_get_id(channel);
}

void IioDevice::keep_whole_triads() {
  for (const SamplePart part : {kAcc, kGyr, kMag, kTemp}) {
    const auto is_of = [part](const Channel& c) { return c.kind.part == part; };
    const auto count = std::count_if(channels_.begin(), channels_.end(), is_of);
    if (count == (part == kTemp ? 1 : 3))
      parts_ = static_cast<std::uint8_t>(parts_ | part);
    else
      channels_.erase(std::remove_if(channels_.begin(), channels_.end(), is_of), channels_.end());
  }
  // A thermometer that cannot be streamed with the others is not worth polling all of them.
  const auto slow = [](const Channel& c) { return c.kind.part == kTemp && !decodable(c.handle); };
  if (std::any_of(channels_.begin(), channels_.end(), [](const Channel& c) { return decodable(c.handle); }) &&
      std::any_of(channels_.begin(), channels_.end(), slow)) {
    channels_.erase(std::remove_if(channels_.begin(), channels_.end(), slow), channels_.end());
    parts_ = static_cast<std::uint8_t>(parts_ & ~kTemp);
  }
  for (const Channel& c : channels_) {
    if (c.kind.axis != 0) continue;
    if (c.kind.part == kAcc) acc_mount_ = mount_of(c);
    if (c.kind.part == kGyr) gyr_mount_ = mount_of(c);
    if (c.kind.part == kMag) mag_mount_ = mount_of(c);
  }
}

std::optional<Mat3> IioDevice::mount_of(const Channel& channel) const {
  for (const std::string& text : {attribute(channel.handle, "mount_matrix"), attribute(device_, "in_mount_matrix"),
                                  attribute(device_, "mount_matrix")})
    if (auto matrix = parse_mount_matrix(text)) return matrix;
  return std::nullopt;
}

double IioDevice::rate_hz() const {
  double rate = 0.0;
  for (const Channel& c : channels_)
    if (iio_channel_find_attr(c.handle, "sampling_frequency") != nullptr &&
        iio_channel_attr_read_double(c.handle, "sampling_frequency", &rate) >= 0)
      return rate;
  if (iio_device_find_attr(device_, "sampling_frequency") != nullptr &&
      iio_device_attr_read_double(device_, "sampling_frequency", &rate) >= 0)
    return rate;
  return 0.0;
}

double IioDevice::step_of(SamplePart part) const noexcept {
  for (const Channel& c : channels_)
    if (c.kind.part == part) return c.scale.scale;
  return 0.0;
}

void IioDevice::set_rate(double rate_hz) const {
  if (rate_hz <= 0.0) return;
  for (const Channel& c : channels_)
    if (iio_channel_find_attr(c.handle, "sampling_frequency") != nullptr)
      (void)iio_channel_attr_write_double(c.handle, "sampling_frequency", rate_hz);
  if (iio_device_find_attr(device_, "sampling_frequency") != nullptr)
    (void)iio_device_attr_write_double(device_, "sampling_frequency", rate_hz);
}

std::string IioDevice::start(const io::IioParams& params) {
  set_rate(params.rate_hz);
  if (!can_stream_)
    return fmt::format("{} has no buffer: its interrupt line is not wired, or its driver has none", name_);
  if (iio_device_find_attr(device_, "current_timestamp_clock") != nullptr)
    (void)iio_device_attr_write(device_, "current_timestamp_clock", "monotonic");
  if (!params.trigger.empty()) {
    const iio_device* trigger = iio_context_find_device(iio_device_get_context(device_), params.trigger.c_str());
    if (trigger == nullptr) return fmt::format("there is no trigger {}", params.trigger);
    if (const int code = iio_device_set_trigger(device_, trigger); code < 0)
      return fmt::format("{} does not take the trigger {}: {}", name_, params.trigger, iio_reason(-code));
  }
  for (const Channel& c : channels_) iio_channel_enable(c.handle);
  if (timestamp_ != nullptr) iio_channel_enable(timestamp_);
  const double rate = rate_hz(), block = std::max(1.0, std::ceil(rate * params.block_s));
  (void)iio_device_set_kernel_buffers_count(device_,
                                            static_cast<unsigned>(std::ceil(kKept_s * std::max(rate, 100.0) / block)));
  buffer_.reset(iio_device_create_buffer(device_, static_cast<std::size_t>(block), false));
  if (buffer_ == nullptr) return fmt::format("{} cannot be streamed: {}", name_, iio_reason(errno));
  return {};
}

void IioDevice::put(const Channel& channel, double value, Reading& out) const noexcept {
  RawSample& s = out.sample;
  const double si = channel.scale.apply(value);
  switch (channel.kind.part) {
    case kAcc:
      s.acc_mps2[channel.kind.axis] = si;
      break;
    case kGyr:
      s.gyr_radps[channel.kind.axis] = si;
      break;
    case kMag:
      s.mag_uT[channel.kind.axis] = si;
      break;
    default:
      s.temp_degC = si;
  }
}

void IioDevice::finish(Reading& reading) const noexcept {
  const auto turn = [](const std::optional<Mat3>& mount, Array3& v) {
    if (mount) v = array(Vec3(*mount * vec(std::as_const(v))));
  };
  turn(acc_mount_, reading.sample.acc_mps2);
  turn(gyr_mount_, reading.sample.gyr_radps);
  turn(mag_mount_, reading.sample.mag_uT);
  reading.sample.has = parts_;
}

int IioDevice::read(const Take& take) { return buffer_ != nullptr ? read_block(take) : poll(take); }

int IioDevice::read_block(const Take& take) {
  const auto bytes = iio_buffer_refill(buffer_.get());
  if (bytes < 0) return static_cast<int>(bytes);
  const std::ptrdiff_t step = iio_buffer_step(buffer_.get());
  const auto* end = static_cast<const std::uint8_t*>(iio_buffer_end(buffer_.get()));
  const auto first = [this](const iio_channel* channel) {
    return static_cast<const std::uint8_t*>(iio_buffer_first(buffer_.get(), channel));
  };
  const std::ptrdiff_t scans = step > 0 ? (end - first(channels_.front().handle) + step - 1) / step : 0;
  for (std::ptrdiff_t k = 0; k < scans; ++k) {
    Reading reading;
    for (const Channel& c : channels_)
      put(c, static_cast<double>(iio_element_value(first(c.handle) + k * step, c.element)), reading);
    if (timestamp_ != nullptr) {
      reading.has_time = true;
      reading.sample.t_ns = iio_element_value(first(timestamp_) + k * step, element_of(timestamp_));
    }
    finish(reading);
    take(reading);
  }
  return 0;
}

int IioDevice::poll(const Take& take) {
  Reading reading;
  for (const Channel& c : channels_) {
    double value = 0.0;
    const bool raw = iio_channel_find_attr(c.handle, "raw") != nullptr;
    const int code = iio_channel_attr_read_double(c.handle, raw ? "raw" : "input", &value);
    if (code < 0) return code;
    put(c, value, reading);
  }
  finish(reading);
  take(reading);
  return 0;
}

void IioDevice::cancel() noexcept {
  if (buffer_ != nullptr) iio_buffer_cancel(buffer_.get());
}

}  // namespace stillpoint::sources
