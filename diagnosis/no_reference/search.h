/// Which law explains best what gyroscope, magnetometer and rests leave, searched in the linear model of
/// model.h.
#pragma once
#include <array>
#include <cmath>
#include <vector>

#include "diagnosis/no_reference/laws.h"

namespace stillpoint::diag::detail {

inline constexpr double kAbstain_nats = 7.0;     ///< after the charges; e^-7 is one false name in a thousand
inline constexpr double kEquivalent_nats = 2.5;  ///< names within this of the best are given together

struct Candidate {
  const WitnessedLaw* law = nullptr;
  double grid_value = 0.0;
  std::array<double, 2> grid_ci95{};
  LawFit fit;
  Eigen::VectorXd applied;   ///< what of it has been taken out of the readings; empty: nothing
  double charges = 0.0;      ///< for parameters and for having searched
  double score = -HUGE_VAL;  ///< gain less the charges
};

/// Whether the fitted numbers are of a size that the law can have.
[[nodiscard]] bool plausible(const Candidate& candidate);

struct Agreement {
  double nats = 0.0;
  Eigen::VectorXd sd;  ///< of the law's values, by all that may make them
};

/// What the values are worth where the stretches of the recording, against each other, have a say as well as the noise,
/// and beside offsets that wander: a rest that is none, or an attitude bent for a while, makes a law from one stretch.
[[nodiscard]] Agreement agreement(const SelfConsistency& model, const Candidate& candidate);

/// Every law at its best, by score, highest first. `laws` must outlive the candidates.
[[nodiscard]] std::vector<Candidate> rank(const SelfConsistency& model, const std::vector<WitnessedLaw>& laws);

/// A large effect bends the attitude that was settled around it, and the calibrations with it: it is taken out of the
/// readings and fitted again around what follows, until nothing changes, or, after a fair trial, more than
/// `hopeless_nats` are left. `taken`: the columns of which candidate.applied has been taken out already.
void relinearise(SelfConsistency& model, Candidate& candidate, double hopeless_nats, std::vector<LawColumn> taken = {});

/// Takes the entries of a simulation that the laws can witness out of the readings, and settles again.
void take_out_given(SelfConsistency& model, const std::vector<WitnessedLaw>& laws,
                    const std::vector<sim::EffectConfig>& given);

/// Score of an offset of its own in every rest, comparable with those of the laws.
[[nodiscard]] double drift_score(const SelfConsistency& model, Sensor sensor);

}  // namespace stillpoint::diag::detail
