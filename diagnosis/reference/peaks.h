/// Where rows swing at one sharp frequency: the highest bins of their periodogram, and the frequencies beside them.
#pragma once
#include <optional>

#include "diagnosis/reference/series.h"

namespace stillpoint::diag {

/// A bin of the spectrum of rows that were searched, refined.
struct Peak {
  double frequency_Hz = 0.0, over_background = 0.0, bin_Hz = 0.0;
};

[[nodiscard]] inline double bin_width_Hz(Eigen::Index rows, double step_s) {
  return 1.0 / (static_cast<double>(rows) * step_s);
}

/// The sharpest line, if there is one: in the whole, or in a half or a quarter of it that it fills better.
[[nodiscard]] std::optional<Peak> sharpest_peak(const Series3& left, const Series& t_s, double step_s,
                                                double lowest_Hz);

/// What sine and cosine at one frequency explain of the three axes. Near half the rate the two are hardly apart.
[[nodiscard]] double power_at(const Series3& x, const Series& t_s, double frequency_Hz);

/// The frequency within reach of this one at which the three axes together swing most.
[[nodiscard]] double refined_Hz(const Series3& x, const Series& t_s, double frequency_Hz, double reach_Hz,
                                double half_rate_Hz);

/// Nearer to half the rate no recording can tell a line from a flip from sample to sample. `bin_Hz`: of the whole.
[[nodiscard]] inline bool is_flip(double frequency_Hz, double bin_Hz, double half_rate_Hz) {
  return half_rate_Hz - frequency_Hz < 0.25 * bin_Hz;
}

/// Whether lines stand at even steps below this one, too: the harmonics of something periodic, such as walking.
[[nodiscard]] bool is_a_harmonic(const Series3& x, double step_s, double frequency_Hz);

}  // namespace stillpoint::diag
