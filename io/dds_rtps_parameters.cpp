#include "io/dds_rtps_parameters.h"

#include <algorithm>
#include <array>
#include <cstdint>

#include "io/dds_rtps_security.h"
#include "io/dds_rtps_text.h"

namespace stillpoint::io {
namespace {

constexpr std::uint16_t kPad = 0x0000, kEnd = 0x0001, kParticipantGuid = 0x0050;
constexpr int kMostParameters = 256;  // a participant of Fast DDS or Cyclone DDS sends some twenty

enum class Shape : std::uint8_t {
  kFixed,
  kText,
  kOctets,
  kTexts,
  kTextPairs,
  kNumbers16,
  kNumbers64,
  kToken,
  kRemoved
};

struct Known {
  std::uint16_t id;
  Shape shape;
  std::uint16_t least;  ///< bytes, of what is fixed
};

/// RTPS 2.3 table 9.13, DDS-Security 1.1, and those of eProsima that Fast DDS 2.9 reads.
constexpr std::array kKnown{
    Known{0x0002, Shape::kFixed, 8},     Known{0x0004, Shape::kFixed, 8},     Known{0x0005, Shape::kText, 0},
    Known{0x0006, Shape::kFixed, 4},     Known{0x0007, Shape::kText, 0},      Known{0x000f, Shape::kFixed, 4},
    Known{0x0015, Shape::kFixed, 2},     Known{0x0016, Shape::kFixed, 2},     Known{0x001a, Shape::kFixed, 12},
    Known{0x001b, Shape::kFixed, 12},    Known{0x001d, Shape::kFixed, 4},     Known{0x001e, Shape::kFixed, 28},
    Known{0x001f, Shape::kFixed, 4},     Known{0x0021, Shape::kFixed, 8},     Known{0x0023, Shape::kFixed, 8},
    Known{0x0025, Shape::kFixed, 4},     Known{0x0027, Shape::kFixed, 8},     Known{0x0029, Shape::kTexts, 0},
    Known{0x002b, Shape::kFixed, 8},     Known{0x002c, Shape::kOctets, 0},    Known{0x002d, Shape::kOctets, 0},
    Known{0x002e, Shape::kOctets, 0},    Known{0x002f, Shape::kFixed, 24},    Known{0x0030, Shape::kFixed, 24},
    Known{0x0031, Shape::kFixed, 24},    Known{0x0032, Shape::kFixed, 24},    Known{0x0033, Shape::kFixed, 24},
    Known{0x0034, Shape::kFixed, 4},     Known{0x0035, Shape::kRemoved, 0},   Known{0x0040, Shape::kFixed, 8},
    Known{0x0041, Shape::kFixed, 12},    Known{0x0043, Shape::kFixed, 1},     Known{0x0044, Shape::kFixed, 4},
    Known{0x0049, Shape::kFixed, 4},     Known{0x0050, Shape::kFixed, 16},    Known{0x0051, Shape::kFixed, 16},
    Known{0x0052, Shape::kFixed, 16},    Known{0x0053, Shape::kFixed, 4},     Known{0x0058, Shape::kFixed, 4},
    Known{0x0059, Shape::kTextPairs, 0}, Known{0x005a, Shape::kFixed, 16},    Known{0x0060, Shape::kFixed, 4},
    Known{0x0062, Shape::kText, 0},      Known{0x0069, Shape::kRemoved, 0},   Known{0x0070, Shape::kFixed, 16},
    Known{0x0071, Shape::kFixed, 4},     Known{0x0072, Shape::kRemoved, 0},   Known{0x0073, Shape::kNumbers16, 0},
    Known{0x0074, Shape::kFixed, 4},     Known{0x0075, Shape::kRemoved, 0},   Known{0x0077, Shape::kFixed, 4},
    Known{0x0083, Shape::kFixed, 24},    Known{0x1001, Shape::kToken, 0},     Known{0x1002, Shape::kToken, 0},
    Known{0x1004, Shape::kFixed, 8},     Known{0x1005, Shape::kFixed, 8},     Known{0x8002, Shape::kFixed, 16},
    Known{0x8005, Shape::kFixed, 8},     Known{0x8006, Shape::kNumbers64, 0}, Known{0x8007, Shape::kFixed, 4},
    Known{0x800f, Shape::kFixed, 24},
};

bool are_numbers(const RtpsBytes& value, std::size_t bytes_each) noexcept {
  return value.has(0, 4) && value.u32(0) <= (value.size() - 4) / bytes_each;
}

bool fits(const Known& known, const RtpsBytes& value) noexcept {
  std::size_t at = 0;
  switch (known.shape) {
    case Shape::kFixed:
      return value.size() >= known.least;
    case Shape::kText:
      return is_text(value, at);
    case Shape::kOctets:
      return are_numbers(value, 1);
    case Shape::kTexts:
      return is_sequence(value, at, 4, is_text);
    case Shape::kTextPairs:
      return is_sequence(value, at, 8, are_two_texts);
    case Shape::kNumbers16:
      return are_numbers(value, 2);
    case Shape::kNumbers64:
      return are_numbers(value, 8);
    case Shape::kToken:
      return is_data_holder(value, at);
    case Shape::kRemoved:
      return true;
  }
  return false;
}

}  // namespace

std::optional<RtpsParameters> judge_parameters(RtpsBytes list) noexcept {
  RtpsParameters out;
  for (int k = 0; k < kMostParameters; ++k) {
    if (!list.has(out.size, 4)) return std::nullopt;
    const std::uint16_t id = list.u16(out.size), length = list.u16(out.size + 2);
    const std::size_t value_at = out.size + 4;
    if (id == kEnd) return RtpsParameters{value_at, out.participant};
    if (length % 4 != 0 || !list.has(value_at, length)) return std::nullopt;
    const auto* known = std::find_if(kKnown.begin(), kKnown.end(), [id](const Known& one) { return one.id == id; });
    if (known != kKnown.end()) {
      if (!fits(*known, list.part(value_at, length))) return std::nullopt;
      if (known->shape == Shape::kRemoved) list.clear_u16(out.size);
    }
    if (id == kParticipantGuid) out.participant = list.data() + value_at;
    out.size = value_at + length;
  }
  return std::nullopt;
}

}  // namespace stillpoint::io
