#include "io/dds_rtps.h"

#include <algorithm>
#include <cstring>
#include <limits>

#include "io/dds_rtps_bytes.h"
#include "io/dds_rtps_parameters.h"
#include "io/dds_rtps_security.h"

namespace stillpoint::io {
namespace {

constexpr std::size_t kHeader = 20;
constexpr std::uint8_t kPadding = 0x01, kFirstOfVendors = 0x80;
constexpr std::uint8_t kLittleEndian = 0x01, kInlineQos = 0x02, kHasData = 0x04, kHasKey = 0x08;
constexpr std::uint32_t kMostBits = 256;                      // of a set of sequence numbers (9.4.2.6)
constexpr std::uint32_t kMostSample_bytes = 1U << 20U;        // far beyond any of ours, and no memory to fear for
constexpr std::int64_t kLastNumber = std::int64_t{1} << 62U;  // a thousand years at any rate
constexpr std::uint32_t kParticipantWriter = 0x000100c2, kPublicationWriter = 0x000003c2,
                        kSubscriptionWriter = 0x000004c2, kLivelinessWriter = 0x000200c2,
                        kHandshakeWriter = 0x000201c3;  // of DDS-Security 1.1, 7.4.3
constexpr std::uint32_t kParticipantReader = 0x000100c7, kPublicationReader = 0x000003c7,
                        kSubscriptionReader = 0x000004c7, kLivelinessReader = 0x000200c7, kHandshakeReader = 0x000201c4;

struct Submessage {
  std::uint8_t flags;
  RtpsBytes body;
};

bool is_number(std::int64_t n, std::int64_t least) { return n >= least && n <= kLastNumber; }

/// Entity identifiers are bytes, the same in either byte order.
std::uint32_t entity(const RtpsBytes& bytes, std::size_t at) {
  std::uint32_t id = 0;
  for (std::size_t k = 0; k < 4; ++k) id = id << 8U | bytes.u8(at + k);
  return id;
}

/// Whose data it is. A stranger may name any writer: readers of discovery take from writers that they do not know.
std::uint32_t builtin_writer(const RtpsBytes& data) {
  switch (entity(data, 4)) {
    case kParticipantReader:
      return kParticipantWriter;
    case kPublicationReader:
      return kPublicationWriter;
    case kSubscriptionReader:
      return kSubscriptionWriter;
    case kLivelinessReader:
      return kLivelinessWriter;
    case kHandshakeReader:
      return kHandshakeWriter;
    default:
      return entity(data, 8);
  }
}

/// A set at `at`: 4 bytes count of bits, then the words. `tail` bytes follow.
bool is_set(const RtpsBytes& body, std::size_t at, std::size_t tail) {
  const std::uint32_t bits = body.u32(at);
  return body.has(at, 4) && bits <= kMostBits && body.has(at + 4, (bits + 31) / 32 * 4 + tail);
}

bool judge_heartbeat(const Submessage& s) {
  const std::int64_t first = s.body.sequence_number(8), last = s.body.sequence_number(16);
  return s.body.has(0, 28) && is_number(first, 1) && is_number(last, first - 1);
}

bool judge_gap(const Submessage& s) {
  const std::int64_t start = s.body.sequence_number(8), base = s.body.sequence_number(16);
  return s.body.has(0, 28) && is_number(start, 1) && is_number(base, start) && is_set(s.body, 24, 0);
}

bool judge_acknack(const Submessage& s) {
  return s.body.has(0, 24) && is_number(s.body.sequence_number(8), 0) && is_set(s.body, 16, 4);
}

bool judge_nack_frag(const Submessage& s) {
  return s.body.has(0, 28) && is_number(s.body.sequence_number(8), 1) && is_set(s.body, 20, 4);
}

bool judge_heartbeat_frag(const Submessage& s) { return s.body.has(0, 24) && is_number(s.body.sequence_number(8), 1); }

bool judge_info_reply(const Submessage& s) {
  constexpr std::size_t kLocator = 24;
  const std::size_t count = s.body.u32(0);
  if (!s.body.has(0, 4) || count > 32 || !s.body.has(4, count * kLocator)) return false;
  if ((s.flags & 0x02U) == 0) return true;
  const std::size_t second = 4 + count * kLocator;
  return s.body.has(second, 4) && s.body.u32(second) <= 32 && s.body.has(second + 4, s.body.u32(second) * kLocator);
}

/// Where the payload of a DATA or DATA_FRAG begins; none: malformed. `fixed` is the length of what stands before it.
std::optional<std::size_t> payload_at(const Submessage& s, std::size_t fixed) {
  const std::size_t to_inline_qos = s.body.u16(2);
  if (!s.body.has(0, fixed) || to_inline_qos + 4 < fixed || !s.body.has(4, to_inline_qos)) return std::nullopt;
  const std::size_t at = 4 + to_inline_qos;
  if ((s.flags & kInlineQos) == 0) return at;
  const auto list = judge_parameters(s.body.from(at));
  if (!list) return std::nullopt;
  return at + list->size;
}

/// The data of a builtin writer, from the encapsulation header on.
bool judge_discovery(std::uint32_t writer, const RtpsBytes& payload, RtpsMessage& message) {
  const std::uint8_t kind = payload.u8(1);
  if (writer == kLivelinessWriter) {
    const RtpsBytes data = payload.from(4, kind == 1);
    return kind <= 1 && data.has(0, 20) && data.has(20, data.u32(16));
  }
  if (kind != 2 && kind != 3) return false;
  const auto list = judge_parameters(payload.from(4, kind == 3));
  if (!list) return false;
  if (writer != kParticipantWriter) return true;
  message.announces_participant = true;
  message.announces_for_another =
      list->participant != nullptr && !std::equal(message.sender.begin(), message.sender.end(), list->participant);
  return true;
}

bool judge_data(const Submessage& s, RtpsMessage& message) {
  constexpr std::size_t kFixed = 20;
  const auto at = payload_at(s, kFixed);
  if (!at || !is_number(s.body.sequence_number(12), 1)) return false;
  const bool data = (s.flags & kHasData) != 0, key = (s.flags & kHasKey) != 0;
  if (data && key) return false;
  if (!data && !key) return true;
  const RtpsBytes payload = s.body.from(*at);
  if (!payload.has(0, 4) || payload.u8(0) != 0 || payload.u8(1) > 0x0b) return false;
  switch (const std::uint32_t writer = builtin_writer(s.body)) {
    case 0:
      return false;
    case kHandshakeWriter:
      return judge_generic_message(payload);
    case kParticipantWriter:
    case kPublicationWriter:
    case kSubscriptionWriter:
    case kLivelinessWriter:
      return judge_discovery(writer, payload, message);
    default:
      return true;
  }
}

/// Fragments: Fast DDS makes room for the whole sample at the first one, and copies by what the header says. Of what is
/// read before anybody is known none is longer than a datagram.
bool judge_data_frag(const Submessage& s) {
  constexpr std::size_t kFixed = 32;
  const std::uint32_t writer = builtin_writer(s.body);
  if (writer == 0 || writer == kParticipantWriter || writer == kHandshakeWriter) return false;
  const auto at = payload_at(s, kFixed);
  if (!at || !is_number(s.body.sequence_number(12), 1)) return false;
  const std::uint64_t first = s.body.u32(20), count = s.body.u16(24), size = s.body.u16(26), sample = s.body.u32(28);
  if (first == 0 || count == 0 || size == 0 || sample < 4 || sample > kMostSample_bytes) return false;
  const std::uint64_t fragments = (sample + size - 1) / size;
  if (first + count - 1 > fragments) return false;
  const std::uint64_t end = std::min(sample, (first - 1 + count) * size);
  return s.body.size() - *at >= end - (first - 1) * size;
}

/// `id` of RTPS 8.3.3.2; what is unknown is left to be skipped by its length.
bool judge(std::uint8_t id, const Submessage& s, RtpsMessage& message) {
  switch (id) {
    case 0x06:
      return judge_acknack(s);
    case 0x07:
      return judge_heartbeat(s);
    case 0x08:
      return judge_gap(s);
    case 0x09:  // a time stamp, unless it says that there is none
      return (s.flags & 0x02U) != 0 || s.body.has(0, 8);
    case 0x0c:  // another source
      return s.body.has(0, 20);
    case 0x0d:  // a reply address of IPv4
      return s.body.has(0, (s.flags & 0x02U) != 0 ? 16 : 8);
    case 0x0e:  // another destination
      return s.body.has(0, 12);
    case 0x0f:
      return judge_info_reply(s);
    case 0x12:
      return judge_nack_frag(s);
    case 0x13:
      return judge_heartbeat_frag(s);
    case 0x15:
      return judge_data(s, message);
    case 0x16:
      return judge_data_frag(s);
    default:
      return id < kSecureBody || id > kSecureRtpsPostfix || judge_secured(id, s.body);
  }
}

}  // namespace

std::optional<RtpsMessage> judge_rtps(std::span<std::uint8_t> datagram) noexcept {
  if (datagram.size() < kHeader || std::memcmp(datagram.data(), "RTPS", 4) != 0 || datagram[4] != 2)
    return std::nullopt;
  RtpsMessage message;
  std::copy_n(datagram.begin() + 8, message.sender.size(), message.sender.begin());
  for (std::size_t at = kHeader; at < datagram.size();) {
    if (datagram.size() - at < 4) return std::nullopt;
    std::uint8_t& id = datagram[at];
    const std::uint8_t flags = datagram[at + 1];
    RtpsBytes all(datagram, (flags & kLittleEndian) != 0);
    std::size_t length = all.u16(at + 2);
    const bool to_the_end = length == 0 && id != kPadding && !(id == 0x09 && (flags & 0x02U) != 0);
    if (to_the_end) length = datagram.size() - at - 4;
    if (!all.has(at + 4, length)) return std::nullopt;
    if (id >= kFirstOfVendors) {
      // Length 0 is "to the end" of a vendor's submessage but "none" of padding: left as it is, Fast DDS would go on to
      // read as submessages what nobody has judged.
      if (length > std::numeric_limits<std::uint16_t>::max()) return std::nullopt;
      all.set_u16(at + 2, static_cast<std::uint16_t>(length));
      id = kPadding;
    }
    if (!judge(id, {flags, all.part(at + 4, length)}, message)) return std::nullopt;
    at += 4 + length;
    if (at % 4 != 0 && at != datagram.size()) return std::nullopt;
  }
  return message;
}

}  // namespace stillpoint::io
