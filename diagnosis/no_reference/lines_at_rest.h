/// Lines of one frequency that a sensor shows at rest, where nothing else swings: interference, a vibration folded into
/// the band, flips of polarity from sample to sample. The noise model of the rests would take them for noise.
#pragma once
#include <string>
#include <vector>

#include "diagnosis/no_reference/model.h"

namespace stillpoint::diag::detail {

struct LinesAtRest {
  std::vector<Finding> findings;
  std::vector<std::string> notices;
  io::Recording without;  ///< the recording, less what the lines are
};

/// Of every sensor that the simulation has and in which it has no line; `without`: names that must not be said.
[[nodiscard]] LinesAtRest find_lines_at_rest(const io::Recording& recording, const sim::SimulationConfig& simulation,
                                             const std::vector<RestWindow>& rest,
                                             const std::vector<std::string>& without);

}  // namespace stillpoint::diag::detail
