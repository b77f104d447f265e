/// What the floors of bench/latency send: as many bytes as an Attitude has on the wire.
#pragma once
#include <stillpoint_idl/stillpoint.h>

#include <array>
#include <atomic>
#include <cstdint>

#include "core/clock.h"

namespace stillpoint::bench {

struct Payload {
  std::uint64_t sequence = 0;
  std::int64_t due_ns = 0;
  std::array<std::uint8_t, sizeof(msg::Attitude) - 16> rest{};
};
static_assert(sizeof(Payload) == sizeof(msg::Attitude));

/// Shared by the two processes; the receiver sleeps on `head`.
struct SharedRing {
  static constexpr std::uint32_t kSlots = 64;
  std::atomic<std::uint32_t> head{0};
  std::array<Payload, kSlots> slots{};
};

}  // namespace stillpoint::bench
