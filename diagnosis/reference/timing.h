/// Delays, filters, lost samples and clock errors: laws of one or two numbers that are not linear in them, refined by
/// Gauss-Newton on the exact response.
#pragma once
#include "diagnosis/reference/scan.h"

namespace stillpoint::diag {

struct TimingLaw {
  std::string id;                         ///< acc_delay, gyr_lpf, mag_delay, acc_resonance, sys_gap, sys_skew
  std::vector<std::string> names, units;  ///< of the most numbers that it may have
  std::string equation, driver;
  std::vector<Eigen::VectorXd> starts;
  std::function<bool(const Eigen::VectorXd&)> possible;
  std::function<Series3(const Eigen::VectorXd&)> delta;  ///< the predicted residual
};

/// The laws of one sensor; `gap_begin` is the sample where a gap begins; 0: no gap among them.
[[nodiscard]] std::vector<TimingLaw> make_timing_laws(const Signals& s, Sensor sensor, Eigen::Index gap_begin);

struct TimingFit {
  Eigen::VectorXd parameters;
  Columns tangent;  ///< d delta / d parameter at the solution
  Series3 delta;
  double gain_nats = -1.0;  ///< with the given noise
};

/// Best parameters beside the explained columns, the noise given.
[[nodiscard]] TimingFit fit_timing(const Target& target, const Columns& explained, const NoiseModel& noise,
                                   const TimingLaw& law);

}  // namespace stillpoint::diag
