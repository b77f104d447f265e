/// Laws against a driver that is not in the recording: an unknown function of time, and where the driver is a scalar,
/// one that moves the reading along one line in the body. A name that tells no more than that is not stated
/// (docs/decisions/045-driver-not-recorded.md).
#pragma once
#include "diagnosis/reference/judge.h"

namespace stillpoint::diag {

/// What moves the reading along a line in the body and is in no column.
inline constexpr const char* kUnrecordedScalar = "unknown:u(t)";

/// `law`; or the unknown scalar that does the same along one line; or none, where a slow function of time explains
/// beside the law more than the law does beside it.
[[nodiscard]] std::optional<Found> against_the_unrecorded(const Signals& s, const SensorSearch& search,
                                                          const Judge& judge, Found law);

}  // namespace stillpoint::diag
