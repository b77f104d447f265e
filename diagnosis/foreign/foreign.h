/// The diagnosis of a recording against the log of any simulator: what that says the sensors read takes the place of
/// what a reference predicts; all that follows is the same.
#pragma once
#include "diagnosis/diagnose.h"
#include "diagnosis/foreign/alignment.h"

namespace stillpoint::diag {

struct LogAnswer {
  Answer answer;
  io::Recording improved;                 ///< the log at the recording's rows with the found physics and numbers in it
  std::vector<std::string> not_improved;  ///< what was found and is not in it, in words
};

/// Fails (65) where the two cannot be brought together (alignment.h).
[[nodiscard]] Result<LogAnswer> diagnose_log(const io::Recording& log, const io::Recording& recording,
                                             const std::vector<std::string>& without = {},
                                             const std::function<void(double)>& progress = {});

}  // namespace stillpoint::diag
