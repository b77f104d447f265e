/// One term of a law as found, and as the effects that a sensor's search holds.
#pragma once
#include <memory>

#include "diagnosis/discovery/grammar.h"
#include "diagnosis/reference/selection.h"

namespace stillpoint::diag {

/// What a bit of a text costs: a whisper in favour of the simpler; the choice itself is charged with the coefficients.
inline constexpr double kNatsABit = 0.2;

/// Of the gain: what says less than a formula has to explain more than that. A free function says no mechanism.
inline constexpr double kShareOfATable = 0.05;

/// One term of a law as found: an idea with its number, and its columns fitted.
struct Term {
  Idea idea;
  double shape = 0.0;
  double bits = 0.0;  ///< length of its text
  Found found;        ///< the columns of all its texts together
};

/// What an idea's coefficients multiply, for one of its texts' values.
[[nodiscard]] Columns columns_of(const Idea& idea, const Eigen::MatrixXd& value);

/// Terms as effects, each text one of its own.
[[nodiscard]] std::vector<Found> effects_of(const Term& term, Sensor sensor,
                                            const std::shared_ptr<const laws::Columns>& drivers);

}  // namespace stillpoint::diag
