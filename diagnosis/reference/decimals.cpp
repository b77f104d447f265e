#include "diagnosis/reference/decimals.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/forensics/lattice.h"
#include "diagnosis/reference/differences.h"

namespace stillpoint::diag {
namespace {

/// The coarsest rounding among the components of a column of vectors, as a standard deviation.
template <typename Vector>
double rounding_sd(const std::vector<Vector>& rows) {
  double sd = 0.0;
  for (int c = 0; c < Vector::RowsAtCompileTime; ++c) {
    std::vector<double> values;
    for (const Vector& row : rows)
      if (std::isfinite(row[c])) values.push_back(row[c]);
    if (values.empty()) continue;
    const auto [low, high] = std::minmax_element(values.begin(), values.end());
    const double step = printing_step(values);
    if (*high - *low > step) sd = std::max(sd, step / std::sqrt(12.0));
  }
  return sd;
}

}  // namespace

RoundingNoise rounding_noise(const io::Recording& recording, double dt_s) {
  return {.rate_radps = 2.0 * noise_of_derivative(rounding_sd(recording.ref_q_world_body), dt_s),
          .acceleration_mps2 = noise_of_second_derivative(rounding_sd(recording.ref_position_m), dt_s)};
}

}  // namespace stillpoint::diag
