/// Several recordings of one sensor, other days and other motions, against one simulation: what they say together.
/// Numbers are weighed by their stated variances; where they scatter more than these allow the pooled interval grows by
/// as much (Birge, "The calculation of errors by the method of least squares", Phys. Rev. 40, 1932).
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "diagnosis/diagnose.h"

namespace stillpoint::diag {

struct CampaignPart {
  std::string file;
  const io::Recording* recording = nullptr;
  Answer answer;  ///< of this recording alone
};

/// An effect that belongs to the sensor, not to a moment: no step at a time, no window.
struct SharedEffect {
  Finding pooled;                          ///< of the recording that shows it best, with the pooled parameters
  std::vector<std::size_t> found_in;       ///< parts
  std::vector<double> chi2;                ///< of each parameter about its pooled value, found_in.size() - 1 degrees
  std::vector<std::size_t> apart;          ///< parts with a number off what the others say, by more than chance
  std::optional<sim::EffectConfig> entry;  ///< for the simulation
  bool confirmed = false;                  ///< by a second part that shows it, or that it explains in part
  bool contradicted = false;               ///< it makes its sensor worse on a part that does not show it
};

struct Campaign {
  std::vector<SharedEffect> effects;  ///< those that most parts show first
  std::vector<Validation> by_others;  ///< what the other parts' effects remove on each part, sensor by sensor
  std::vector<std::string> own;       ///< what single parts show beside them, in words
};

/// The effects of these answers, pooled; `leave_out` is not asked.
[[nodiscard]] std::vector<SharedEffect> shared_effects(const std::vector<CampaignPart>& parts,
                                                       std::optional<std::size_t> leave_out = std::nullopt);

/// Pre: two parts at least.
[[nodiscard]] Campaign join(const std::vector<CampaignPart>& parts, const sim::SimulationConfig& simulation);

/// The simulation with what is confirmed and not contradicted. Bias and matrix stay: they are each day's own.
[[nodiscard]] sim::SimulationConfig improved_by(const Campaign& campaign, sim::SimulationConfig simulation);

[[nodiscard]] std::string to_text(const Campaign& campaign, const std::vector<CampaignPart>& parts);
/// stillpoint.campaign/1 (docs/formats.md)
[[nodiscard]] std::string to_json(const Campaign& campaign, const std::vector<CampaignPart>& parts);

}  // namespace stillpoint::diag
