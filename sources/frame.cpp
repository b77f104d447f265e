#include "sources/frame.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

namespace stillpoint::sources {
namespace {

static_assert(std::endian::native == std::endian::little, "the frame's numbers are copied as they are");

constexpr std::uint8_t kAllParts = kAcc | kGyr | kMag | kTemp;

std::size_t payload_size(std::uint8_t flags) noexcept {
  std::size_t size = 1 + ((flags & kFrameHasTime) != 0 ? 4U : 0U) + ((flags & kTemp) != 0 ? 4U : 0U);
  for (const SamplePart part : {kAcc, kGyr, kMag}) size += (flags & part) != 0 ? 12U : 0U;
  return size;
}

class PayloadReader {
 public:
  explicit PayloadReader(const std::uint8_t* at) noexcept : at_(at) {}
  template <class T>
  T take() noexcept {
    T value;
    std::memcpy(&value, at_, sizeof value);
    at_ += sizeof value;
    return value;
  }
  /// False: an axis is no number.
  bool triad(Array3& out) noexcept {
    for (double& x : out) x = static_cast<double>(take<float>());
    return std::all_of(out.begin(), out.end(), [](double x) { return std::isfinite(x); });
  }

 private:
  const std::uint8_t* at_;
};

/// Pre: as many bytes as its flags ask for.
Reading read_payload(const std::uint8_t* payload) noexcept {
  Reading out;
  PayloadReader reader(payload);
  const auto flags = reader.take<std::uint8_t>();
  out.has_time = (flags & kFrameHasTime) != 0;
  if (out.has_time) {
    out.sample.t_ns = std::int64_t{reader.take<std::uint32_t>()} * 1000;
    out.time_unit_ns = 1000.0;
  }
  const auto keep = [&](SamplePart part, bool finite) {
    if (finite) out.sample.has = static_cast<std::uint8_t>(out.sample.has | part);
  };
  if ((flags & kAcc) != 0) keep(kAcc, reader.triad(out.sample.acc_mps2));
  if ((flags & kGyr) != 0) keep(kGyr, reader.triad(out.sample.gyr_radps));
  if ((flags & kMag) != 0) keep(kMag, reader.triad(out.sample.mag_uT));
  if ((flags & kTemp) != 0) {
    out.sample.temp_degC = static_cast<double>(reader.take<float>());
    keep(kTemp, std::isfinite(out.sample.temp_degC));
  }
  return out;
}

/// So many bytes cannot begin a frame; at least one.
std::size_t to_next_sync(std::span<const std::uint8_t> bytes) noexcept {
  const auto next = std::find(bytes.begin() + 1, bytes.end(), kSync[0]);
  return static_cast<std::size_t>(next - bytes.begin());
}

}  // namespace

std::uint16_t crc16(std::span<const std::uint8_t> bytes) noexcept {
  unsigned crc = 0xFFFF;
  for (const std::uint8_t byte : bytes) {
    crc ^= static_cast<unsigned>(byte) << 8U;
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 0x8000U) != 0 ? (crc << 1U) ^ 0x1021U : crc << 1U;
    crc &= 0xFFFFU;
  }
  return static_cast<std::uint16_t>(crc);
}

Frame take_frame(std::span<const std::uint8_t> bytes) noexcept {
  Frame out;
  if (bytes.empty()) return out;
  const auto malformed = [&] {
    out.piece = Piece::kMalformed;
    out.size = to_next_sync(bytes);
    return out;
  };
  if (bytes[0] != kSync[0] || (bytes.size() > 1 && bytes[1] != kSync[1])) return malformed();
  if (bytes.size() > 2 && (bytes[2] == 0 || bytes[2] > kLongestPayload)) return malformed();
  if (bytes.size() < 5) return out;
  const std::size_t payload = bytes[2], size = kFrameOverhead + payload;
  const std::uint8_t flags = bytes[4];
  if ((flags & ~(kAllParts | kFrameHasTime)) != 0 || payload_size(flags) != payload) return malformed();
  if (bytes.size() < size) return out;
  const auto sent = static_cast<std::uint16_t>(bytes[size - 2] | (bytes[size - 1] << 8U));
  if (crc16(bytes.subspan(2, payload + 2)) != sent) return malformed();
  out.size = size;
  out.counter = bytes[3];
  out.reading = read_payload(bytes.data() + 4);
  out.piece = out.reading.sample.has != 0 ? Piece::kReading : Piece::kIgnored;
  return out;
}

std::size_t write_frame(const Reading& reading, std::uint8_t counter,
                        std::span<std::uint8_t, kLongestFrame> out) noexcept {
  std::size_t at = 4;
  const auto put = [&](const auto& value) {
    std::memcpy(out.data() + at, &value, sizeof value);
    at += sizeof value;
  };
  const RawSample& s = reading.sample;
  put(static_cast<std::uint8_t>(s.has | (reading.has_time ? kFrameHasTime : 0)));
  if (reading.has_time) put(static_cast<std::uint32_t>(s.t_ns / 1000));
  const auto put_triad = [&](SamplePart part, const Array3& v) {
    if (!s.holds(part)) return;
    for (const double x : v) put(static_cast<float>(x));
  };
  put_triad(kAcc, s.acc_mps2);
  put_triad(kGyr, s.gyr_radps);
  put_triad(kMag, s.mag_uT);
  if (s.holds(kTemp)) put(static_cast<float>(s.temp_degC));
  out[0] = kSync[0];
  out[1] = kSync[1];
  out[2] = static_cast<std::uint8_t>(at - 4);
  out[3] = counter;
  put(crc16(std::span<const std::uint8_t>(out.data() + 2, at - 2)));
  return at;
}

}  // namespace stillpoint::sources
