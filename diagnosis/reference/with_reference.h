/// The diagnosis of a recording that has a reference orientation: the examinations of diagnosis/reference/ in their
/// order.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "diagnosis/diagnose.h"
#include "diagnosis/forensics/forensics.h"

namespace stillpoint::diag {

struct AlignedLog;

struct ReferencedRows {
  const io::Recording& recording;
  std::size_t rows_a_frame = 1;     ///< of a reference whose frames are slower (sanity/rows_with_reference.h)
  const AlignedLog* log = nullptr;  ///< of another simulator, in the reference's place; none where nullptr
};

/// `answer` carries the notices so far; findings, verdict and summary are added. Insufficient data where nothing can be
/// compared, the reason in the notices. The other arguments are those of diagnose().
[[nodiscard]] Answer diagnose_with_reference(const ReferencedRows& rows, const sim::SimulationConfig& simulation,
                                             const Forensics& forensics, const std::vector<std::string>& without,
                                             std::size_t twins, const std::function<void(double)>& progress,
                                             Answer answer);

}  // namespace stillpoint::diag
