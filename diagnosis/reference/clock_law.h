/// How late a law of a clock makes the rows.
#pragma once
#include "diagnosis/reference/selection.h"

namespace stillpoint::diag {

/// How late each row is, s, by each number of a timing law at one, a column each; none of a filter with two numbers.
[[nodiscard]] Eigen::MatrixXd lateness(const Signals& s, const Found& f);

/// By how much a clock makes its sensor late, at most, s; infinite of a law that is none of a clock.
[[nodiscard]] double most_late(const Signals& s, const Found& f, const Eigen::VectorXd& numbers);

/// Deviations of its numbers by chance, where rows deviate at random in time as well; of other laws none.
[[nodiscard]] Eigen::VectorXd chance_by_jitter(const Signals& s, const Found& f, const Layout& layout);

}  // namespace stillpoint::diag
