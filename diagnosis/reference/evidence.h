/// What supports a finding: its gain on data not used for the fit, its p-value, and whether what is left is noise.
#pragma once
#include "diagnosis/reference/selection.h"
#include "diagnosis/result.h"

namespace stillpoint::diag {

/// The finished model of one sensor: every found effect with the noise estimated beside it.
struct Finished {
  Fit fit;
  Eigen::VectorXd values;                               ///< per explained column: coefficient, or timing parameter
  Eigen::VectorXd sd;                                   ///< of the values, the time constants of their laws free
  std::vector<std::map<std::string, double>> inner_sd;  ///< per effect, by name: of the numbers inside of its law
  double walk_gain_nats = 0.0;                          ///< what a random walk adds
};
[[nodiscard]] Finished finish(const SensorSearch& search);

/// The number of one of its columns, with its interval.
[[nodiscard]] Parameter number_of(const Finished& finished, Eigen::Index column, std::string name, std::string unit);

/// First column of effect `index` among the explained ones.
[[nodiscard]] Eigen::Index first_column(const SensorSearch& search, std::size_t index);

/// Blocks of 4 s: fitted on every second one, judged on the others, then exchanged. Where half of the blocks do not
/// tell bias and matrix, each is judged by all others. Before: without the given effects, by index, ascending.
[[nodiscard]] HeldOut held_out(const SensorSearch& search, const std::vector<std::size_t>& effects);

/// The same with the share that is removed on kinds of motion left out of the fit, and its interval; what is local in
/// time on blocks, as it is in one kind only. Of what is removable: of a name, what the coefficients of other kinds can
/// remove, where the name is true; kinds that tell too little of it are no test, and blocks are taken.
[[nodiscard]] HeldOut held_out_by_regime(const SensorSearch& search, const std::vector<std::size_t>& effects);

/// Whether blocks are told by others. What acts in one of them alone gains there too where each is judged by all
/// others: a coefficient that nothing is known of is better than none.
[[nodiscard]] bool predicts(const HeldOut& h);

/// Whether a share with an interval is known of it.
[[nodiscard]] bool is_judged(const HeldOut& h);

/// Judged, and not sure, with 97.5 %, to remove half of what is removable.
[[nodiscard]] bool is_unsure(const HeldOut& h);

/// A law that is the cause removes nearly all that is removable wherever it acts; of what only goes along with the
/// cause, not half is left elsewhere. A name claims to be the cause, a product may be one term of several: where a name
/// gains enough to tell, it has to remove 0.75. Of 96 true names on two generators none removed less than 0.82, of five
/// untrue ones that gained little three less than 0.68.
[[nodiscard]] bool fails_elsewhere(const HeldOut& h, const std::string& id);

/// Upper tail of chi-square with k degrees of freedom.
[[nodiscard]] double chi_square_tail(double x, double k);

/// Ljung-Box over 20 lags, the largest of the three axes' statistics: true when it stays below the 99.9 % point.
[[nodiscard]] bool is_white(const Series& x, const Layout& layout);

}  // namespace stillpoint::diag
