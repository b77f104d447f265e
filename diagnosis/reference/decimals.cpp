#include "diagnosis/reference/decimals.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/forensics/lattice.h"
#include "diagnosis/reference/differences.h"

namespace stillpoint::diag {
namespace {

constexpr int kMostDigits = 10;      // significant ones; more are arithmetic
constexpr int kFloatDigits = 8;      // as many as a number of single precision needs to be written
constexpr double kFloatText = 6e-9;  // what its nine digits leave
constexpr double kFloatRounding = 1.0 / (1 << 23);

bool has_digits(double x, int digits) {
  if (x == 0.0) return true;
  const double scale = std::pow(10.0, digits - 1 - std::floor(std::log10(std::abs(x))));
  return std::abs(x * scale - std::round(x * scale)) < 1e-6 + 1e-14 * std::abs(x * scale);
}

/// Mean square step of a writer of so many significant digits ("%.8g"), or of single precision: larger values have
/// larger ones. 0 where the values have all digits that arithmetic has.
double square_of_relative_steps(const std::vector<double>& values) {
  int digits = 1;
  for (const double x : values)
    while (digits <= kMostDigits && !has_digits(x, digits)) ++digits;
  const bool single = digits >= kFloatDigits && std::all_of(values.begin(), values.end(), [](double x) {
                        return std::abs(x - static_cast<double>(static_cast<float>(x))) <= kFloatText * std::abs(x);
                      });
  if (digits > kMostDigits && !single) return 0.0;
  double sum = 0.0;
  for (const double x : values) {
    if (x == 0.0) continue;
    const double step = single ? kFloatRounding * std::exp2(std::floor(std::log2(std::abs(x))))
                               : std::pow(10.0, std::floor(std::log10(std::abs(x))) + 1 - digits);
    sum += step * step;
  }
  return sum / static_cast<double>(values.size());
}

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
    const double decimals = printing_step(values),
                 step = std::sqrt(std::max(decimals * decimals, square_of_relative_steps(values)));
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
