/// The search over the grammar in one sensor's residual: every idea on thinned rows, a short list on all of them,
/// further factors on the best, each judged with the noise estimated beside it and a charge for its length.
#pragma once
#include <memory>

#include "diagnosis/discovery/grammar.h"
#include "diagnosis/reference/selection.h"

namespace stillpoint::diag {

/// What a bit of a text costs: a whisper in favour of the simpler; the choice itself is charged with the coefficients.
inline constexpr double kNatsABit = 0.2;

/// One term of a law as found: an idea with its number, and its columns fitted.
struct Term {
  Idea idea;
  double shape = 0.0;
  double bits = 0.0;  ///< length of its text
  Found found;        ///< the columns of all its texts together
};

/// Terms as effects, each text one of its own.
[[nodiscard]] std::vector<Found> effects_of(const Term& term, Sensor sensor,
                                            const std::shared_ptr<const laws::Columns>& drivers);

class LawSearch {
 public:
  /// `rows`: about so many are looked at; what is found is judged on all.
  LawSearch(const Signals& s, Sensor sensor, double rows);
  ~LawSearch();
  LawSearch(const LawSearch&) = delete;
  LawSearch& operator=(const LawSearch&) = delete;

  /// The most that any single idea could gain beside what `base` explains, in nats of a noise that knows nothing of it.
  [[nodiscard]] double most(const SensorSearch& base);
  /// The best next terms, best first, each judged; none where no idea pays for itself.
  [[nodiscard]] std::vector<Term> next(const SensorSearch& base);
  [[nodiscard]] const std::shared_ptr<const laws::Columns>& drivers() const;

 private:
  struct Parts;
  class Round;
  std::unique_ptr<Parts> parts_;
};

}  // namespace stillpoint::diag
