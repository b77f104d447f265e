/// The search over the grammar in one sensor's residual: every idea on thinned rows, a short list on all of them,
/// further factors on the best, each judged with the noise estimated beside it and a charge for its length.
#pragma once
#include <memory>
#include <span>

#include "diagnosis/discovery/term.h"

namespace stillpoint::diag {

class LawSearch {
 public:
  /// `lines_hz`: frequencies that the sensor's residual has a line at; `moments_s`: where something begins or ends.
  LawSearch(const Signals& s, Sensor sensor, std::span<const double> lines_hz, std::span<const double> moments_s);
  ~LawSearch();
  LawSearch(const LawSearch&) = delete;
  LawSearch& operator=(const LawSearch&) = delete;

  /// The most that any single idea gains beside what `base` explains and a walk, on few rows.
  [[nodiscard]] double most(const SensorSearch& base);
  /// The best next terms, best first, each judged; none where no idea pays for itself.
  [[nodiscard]] std::vector<Term> next(const SensorSearch& base);
  /// The same of what begins at one of the moments. A list of its own: a jump gains so much that what else there is
  /// would not be looked at beside it, be it a jump of the driver.
  [[nodiscard]] std::vector<Term> next_event(const SensorSearch& base);
  [[nodiscard]] const std::shared_ptr<const laws::Columns>& drivers() const;

 private:
  struct Parts;
  class Round;
  std::unique_ptr<Parts> parts_;
};

}  // namespace stillpoint::diag
