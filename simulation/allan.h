/// Noise of a sensor at rest: overlapping Allan deviation, and the noise terms that explain it.
/// After IEEE Std 952-1997 (2008), Annex C: eqs. C.1 (quantisation), C.3 (white noise), C.5 (bias instability),
/// C.7 (rate random walk); and Riley, "Handbook of Frequency Stability Analysis", NIST SP 1065, eq. (11).
#pragma once
#include <array>
#include <span>
#include <vector>

namespace stillpoint::sim {

struct AllanPoint {
  double tau_s = 0.0;
  double deviation = 0.0;       ///< unit of the reading
  double relative_error = 0.0;  ///< one sigma, of the deviation
};

/// Overlapping Allan deviation at averaging times spaced evenly in log tau (about ten a decade), from one sample up to
/// a ninth of the record, beyond which too few independent clusters are left to say anything. Fewer than 9 samples give
/// nothing.
[[nodiscard]] std::vector<AllanPoint> allan_deviation(std::span<const double> reading, double dt_s);

enum NoiseKind : std::size_t { kQuantisation, kWhite, kInstability, kRandomWalk, kNoiseKinds };

/// sigma^2(tau) = 3 Q^2/tau^2 + N^2/tau + (2 ln 2/pi) B^2 + K^2 tau/3. A term that the data does not demand is zero.
struct NoiseTerms {
  std::array<double, kNoiseKinds> value{};  ///< Q [unit s], N [unit/sqrt(Hz)], B [unit], K [unit/sqrt(s)]
  std::array<double, kNoiseKinds> standard_error{};
  /// Upper limit (95 %) of a term that is zero, else 0: what could be there without being seen.
  std::array<double, kNoiseKinds> upper_limit{};
};

/// Weighted non-negative least squares on the Allan variance; of all subsets of terms the one with the least BIC.
/// Needs at least four points.
[[nodiscard]] NoiseTerms fit_noise_terms(std::span<const AllanPoint> points);

/// The law at one averaging time: the deviation that the terms predict.
[[nodiscard]] double predicted_deviation(const NoiseTerms& terms, double tau_s);

}  // namespace stillpoint::sim
