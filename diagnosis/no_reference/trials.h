/// A law is judged when it has been taken out of the readings, in a model of its own.
#pragma once
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "diagnosis/no_reference/search.h"

namespace stillpoint::diag::detail {

/// Whether so much is left that no law of those tried, or a matrix too wrong to start from, has bent the attitude.
[[nodiscard]] bool bent(const SelfConsistency& model);

/// The laws that are left to be named: what the simulation has was taken out already.
[[nodiscard]] std::vector<WitnessedLaw> open_laws(const SelfConsistency& model, const sim::SimulationConfig& simulation,
                                                  const std::vector<std::string>& without);

/// The model with one law taken out of the readings; the candidate refers to the laws beside it.
struct Trial {
  std::unique_ptr<SelfConsistency> model;
  std::vector<WitnessedLaw> laws;
  Candidate candidate;
  std::optional<Agreement> known{};  ///< agreed(), once it was asked for

  /// Of the model and the candidate as they stay.
  [[nodiscard]] const Agreement& agreed();
};

/// The law that leaves least; none when the best is not worth its charges. How much each leaves shows only when it has
/// been taken out: `ranking` then has their new scores. Where much is left unexplained the attitude is bent, and even
/// laws far behind are tried.
[[nodiscard]] Trial best_of(const SelfConsistency& model, const sim::SimulationConfig& simulation,
                            const std::vector<std::string>& without, std::vector<Candidate>& ranking);

/// The model without the law again, but from where the law has led: lower than it was where it had only lost its way.
[[nodiscard]] std::unique_ptr<SelfConsistency> put_back(const Trial& trial);

}  // namespace stillpoint::diag::detail
