/// The parameter lists of RTPS (9.4.2.11): discovery data and inline quality of service.
#pragma once
#include <cstddef>
#include <optional>

#include "io/dds_rtps_bytes.h"

namespace stillpoint::io {

struct RtpsParameters {
  std::size_t size = 0;                       ///< of the list with its end mark
  const std::uint8_t* participant = nullptr;  ///< GUID of the participant that it describes, 16 bytes; null: not in it
};

/// None: malformed. Parameters that nobody here reads are made into padding in place.
[[nodiscard]] std::optional<RtpsParameters> judge_parameters(RtpsBytes list) noexcept;

}  // namespace stillpoint::io
