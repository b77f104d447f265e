/// The sizes that parts have, by the catalogue.
#pragma once
#include <Eigen/Core>
#include <cmath>
#include <string>
#include <vector>

#include "simulation/effect_catalogue.h"

namespace stillpoint::diag {

/// Whether coefficients of an effect, known to `sd`, may be those of a part: bad parts are 5 times worse than usual
/// ones, and an arm's vibration ten times that. `names` begin with the symbols of the catalogue.
[[nodiscard]] inline bool may_be_of_a_part(const sim::EffectInfo& effect, const std::vector<std::string>& names,
                                           const Eigen::VectorXd& values, const Eigen::VectorXd& sd) {
  constexpr double kBeyondUsual = 50.0;
  for (std::size_t j = 0; j < names.size() && std::ssize(names) == values.size(); ++j)
    for (const auto& p : effect.parameters) {
      const bool coefficient = p.symbol.find_first_of("kSG") == 0 && names[j].starts_with(p.symbol + "_");
      const auto i = static_cast<Eigen::Index>(j);
      if (coefficient && p.typical_high > 0.0 && std::abs(values[i]) - 2.0 * sd[i] >= kBeyondUsual * p.typical_high)
        return false;
    }
  return true;
}

}  // namespace stillpoint::diag
