/// What gains in likelihood say about the truth of an answer: the one place where nats become chances.
#pragma once
#include <algorithm>
#include <cmath>

namespace stillpoint::diag {

inline constexpr double kNatsPerCoefficient = 2.0;  ///< what a law is charged for each number (docs/decisions/043)

/// Bound on the chance that noise alone reaches a gain that is already charged for all that was looked at: under the
/// null the expectation of a likelihood ratio is one (Markov). Nothing below 1e-300 is a number.
[[nodiscard]] inline double chance_of(double net_nats) { return std::exp(-std::clamp(net_nats, 0.0, 690.0)); }

/// Share of answers with so much net gain that are true. A model that is only nearly right misleads by a few percent
/// however much it gains: 0.95 is what `prove` and an independent generator leave for true.
[[nodiscard]] inline double confidence_of(double net_nats) {
  constexpr double kMost = 0.95, kNatsPerOdds = 2.0;
  return kMost / (1.0 + std::exp(-std::min(net_nats / kNatsPerOdds, 30.0)));
}

}  // namespace stillpoint::diag
