/// Whether rows are refused because their stamps do not advance, so many that it is no accident.
#pragma once
#include <string>

#include "pipeline/guard_stage.h"

namespace stillpoint::app {

class RefusedRows {
 public:
  /// A line where it begins or ends; empty: nothing new. `counts` are those so far.
  [[nodiscard]] std::string news(const pipeline::GuardCounts& counts);
  /// What share is refused and what to do about it; empty: none to speak of.
  [[nodiscard]] const std::string& trouble() const noexcept { return trouble_; }
  /// The attitude does not hold what the sensor gives. It does where each row is sent twice.
  [[nodiscard]] bool most() const noexcept { return share_ > 0.55; }

 private:
  std::uint64_t rows_ = 0, refused_ = 0;  ///< when the share was taken last
  double share_ = 0.0;
  std::string trouble_;
};

}  // namespace stillpoint::app
