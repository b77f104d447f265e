/// What a line that is no reading looks like, and what to send instead: a pure function over bytes, no allocation.
#pragma once
#include <cstdint>
#include <string_view>

namespace stillpoint::sources {

enum class LineLook : std::uint8_t { kUnknown, kDecimalCommas, kDate, kJsonArray };

[[nodiscard]] LineLook look_of(std::string_view line) noexcept;

/// Empty for kUnknown.
[[nodiscard]] std::string_view advice(LineLook look) noexcept;

}  // namespace stillpoint::sources
