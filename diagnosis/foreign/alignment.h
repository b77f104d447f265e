/// A log of somebody else's simulator brought to the rows of a recording: its clock, its units and its axes found by
/// what both say of the same motion.
#pragma once
#include <string>
#include <vector>

#include "core/result.h"
#include "diagnosis/reference/signals.h"
#include "io/recording.h"

namespace stillpoint::diag {

/// The log's readings at the recording's rows.
struct AlignedLog {
  std::array<Series3, kSensors> reading;        ///< empty: not in the log
  std::array<Mask, kSensors> unread;            ///< rows of which the log says nothing; empty as `reading`
  double offset_s = 0.0;                        ///< what the recording's time is on the log's clock, at its first row
  double drift = 0.0;                           ///< seconds of the log more, a second of the recording
  std::array<double, kSensors> noise_sd{};      ///< of one reading of the log, above all motion
  std::array<double, kSensors> own_noise_sd{};  ///< of one of the recording
  io::Recording reference;  ///< the recording with a reference: its own, the log's, or the log's turning
  bool summed_up = false;   ///< that is the log's turning: its attitudes drift
  std::vector<std::string> notices;
};

/// Fails (65) where the two do not overlap, are another motion, part at a time that is told, or differ in units (of
/// time, too) or axes: the message says which and what to write.
[[nodiscard]] Result<AlignedLog> align(const io::Recording& log, const io::Recording& recording);

}  // namespace stillpoint::diag
