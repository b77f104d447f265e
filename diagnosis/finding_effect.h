/// From a finding to the entry of a simulation's `effects:` that it stands for.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "diagnosis/result.h"
#include "simulation/config.h"

namespace stillpoint::diag {

/// The finding's numbers under the catalogue's keys: "k_x" and its neighbours become the list k_..., "t0" the time.
/// nullopt: not in the catalogue, or a number that the catalogue requires was not found. Where a number is known of
/// some axes only, the entry acts on those.
[[nodiscard]] std::optional<sim::EffectConfig> effect_of(const Finding& finding);

/// Whether the entry says what the finding does: by its ID, or as its sensor's law or table behind "unknown:".
[[nodiscard]] bool is_entry_of(const sim::EffectConfig& entry, const Finding& finding);

/// Whether they are one effect, and each number of `b` is nearly that of `a`.
[[nodiscard]] bool same_numbers(const sim::EffectConfig& a, const sim::EffectConfig& b);

/// Whether one of the entries is of this effect.
[[nodiscard]] bool contains(const std::vector<sim::EffectConfig>& entries, const std::string& id);
[[nodiscard]] bool contains(const std::vector<Finding>& findings, const std::string& id);
[[nodiscard]] bool contains(const std::vector<std::string>& ids, const std::string& id);

}  // namespace stillpoint::diag
