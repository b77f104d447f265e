/// What an explanation is worth beside what is already explained: the gain in likelihood with the noise estimated
/// beside it, and that gain less the freedom it took.
#pragma once
#include "diagnosis/reference/selection.h"

namespace stillpoint::diag {

/// Likelihoods over the null, each model with a random walk at a price or without one.
class Judge {
 public:
  explicit Judge(const SensorSearch& search);
  [[nodiscard]] bool walking() const { return walking_; }
  [[nodiscard]] const Target& without_walk() const { return plain_; }
  [[nodiscard]] const Target& beside_walk() const { return beside_walk_; }

  /// Fills in the gain and the net gain.
  void weigh(Found& f) const;

 private:
  Target plain_, beside_walk_;
  Columns explained_;
  double null_ = 0.0;
  double walk_freedom_ = 8.0;  ///< what three rates of a random walk and their name are worth
  bool walking_ = false;
};

}  // namespace stillpoint::diag
