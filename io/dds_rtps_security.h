/// What DDS-Security 1.1 adds to RTPS, as far as it is read before anybody is known: tokens, the messages of the
/// handshake, and the frame around what is encrypted.
#pragma once
#include <cstddef>
#include <cstdint>

#include "io/dds_rtps_bytes.h"

namespace stillpoint::io {

/// The identifiers of secured submessages (7.3.6.6 ff.) lie between these two.
inline constexpr std::uint8_t kSecureBody = 0x30, kSecureRtpsPostfix = 0x34;

/// A token: DataHolder of 7.2.3, from `at` on; moves `at` behind it.
[[nodiscard]] bool is_data_holder(const RtpsBytes& value, std::size_t& at) noexcept;

/// A ParticipantGenericMessage (7.4.3.3), from the encapsulation header on.
[[nodiscard]] bool judge_generic_message(const RtpsBytes& payload) noexcept;

/// The frame of a secured submessage: lengths only, as what is inside can be judged by nobody without the key, and is
/// read by nobody before its code has been checked.
[[nodiscard]] bool judge_secured(std::uint8_t id, const RtpsBytes& body) noexcept;

}  // namespace stillpoint::io
