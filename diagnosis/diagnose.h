/// The whole diagnosis of one recording against one simulation: input checks, forensics on raw values, the search for
/// missing physics, and the answer of result.h.
#pragma once
#include <array>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "diagnosis/result.h"
#include "io/recording.h"
#include "simulation/config.h"

namespace stillpoint::diag {

struct Answer {
  Diagnosis diagnosis;
  std::vector<sim::EffectConfig>
      effects;  ///< the findings as entries for the simulation; findings without a law have none
  std::array<std::optional<sim::TriadConfig>, 3> numbers;  ///< of sensors whose bias or matrix is wrong: the right ones
  std::vector<std::string> surplus;                        ///< effects of the simulation to take out
  double reference_latency_s = 0.0;                        ///< beyond the simulation's; no effect of a sensor
};

/// Never fails: what cannot be judged is the verdict insufficient_data, with the reason among the notices.
/// Effects that the simulation already has are taken out before anything is looked for. `without`: laws that are taken
/// out of the library, to see what is said when the true one is not in it. `twins`: so many null twins a sensor gate
/// what is found with a reference (twins.h); each costs about as much as the search itself. `progress` is told the
/// share of the work that is done, 0 to 1.
[[nodiscard]] Answer diagnose(const io::Recording& recording, const sim::SimulationConfig& simulation,
                              const std::vector<std::string>& without = {}, std::size_t twins = 0,
                              const std::function<void(double)>& progress = {});

/// The answer "insufficient data" for this reason, beside what `answer` says already.
[[nodiscard]] Answer insufficient(std::string why, Answer answer);

}  // namespace stillpoint::diag
