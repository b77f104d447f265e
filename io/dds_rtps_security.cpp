#include "io/dds_rtps_security.h"

#include "io/dds_rtps_text.h"

namespace stillpoint::io {
namespace {

constexpr std::size_t kTwoLengths = 8, kThreeLengths = 12;  // the least that a property, and a token, is made of
constexpr std::size_t kSecureHeader = 20, kMac = 16, kReceiverMac = 20;

bool is_binary_property(const RtpsBytes& value, std::size_t& at) noexcept {
  return is_text(value, at) && is_octets(value, at);
}

/// Its length is big-endian whatever the flags say (9.5.2.5).
bool is_secure_postfix(const RtpsBytes& body) noexcept {
  RtpsBytes macs = body.from(kMac, false);
  return body.has(0, kMac + 4) && macs.u32(0) <= (macs.size() - 4) / kReceiverMac;
}

}  // namespace

bool is_data_holder(const RtpsBytes& value, std::size_t& at) noexcept {
  return is_text(value, at) && is_sequence(value, at, kTwoLengths, are_two_texts) &&
         is_sequence(value, at, kTwoLengths, is_binary_property);
}

bool judge_generic_message(const RtpsBytes& payload) noexcept {
  constexpr std::size_t kIdentities = 96;  // two messages' and three endpoints'
  const std::uint8_t kind = payload.u8(1);
  if (kind > 1) return false;
  const RtpsBytes message = payload.from(4, kind == 1);
  std::size_t at = kIdentities;
  return is_text(message, at) && is_sequence(message, at, kThreeLengths, is_data_holder);
}

bool judge_secured(std::uint8_t id, const RtpsBytes& body) noexcept {
  switch (id) {
    case kSecureBody:
      return body.has(0, 4);
    case 0x31:  // prefix of a submessage
    case 0x33:  // prefix of the rest of the message
      return body.has(0, kSecureHeader);
    default:
      return is_secure_postfix(body);
  }
}

}  // namespace stillpoint::io
