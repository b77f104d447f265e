/// The time of each row, where rows are taken at random times: as all channels tell it together.
#pragma once
#include <array>
#include <vector>

#include "diagnosis/reference/signals.h"

namespace stillpoint::diag {

/// One sensor's rows in motion, in units of its noise.
struct TimedRows {
  Sensor sensor = kAcc;
  std::vector<Eigen::Index> at;
  std::vector<double> along, slope, noise;  ///< residual along the derivative; size of the derivative per s; variance
  Vec3 variance = Vec3::Zero();             ///< of each axis, in the mean over the rows
};

/// What bias, matrix, a delay and smooth curves leave of `y`, a sensor's residual, where rows deviate in time by
/// `sd_s`.
[[nodiscard]] TimedRows rows_of(const Signals& s, Sensor k, const Series3& y, double sd_s);

/// So many white deviations have a mean of their own, s, which is no delay: at most this.
[[nodiscard]] double most_of_a_mean_s(double sd_s, double rows);

/// How late each row is, s, by `y` of each of the sensors, a residual that nothing else is in: the likeliest white
/// deviation of `sd_s`, and the mean that so many of them have.
[[nodiscard]] Series lateness_of(const Signals& s, const std::vector<TimedRows>& sensors,
                                 const std::array<Series3, kSensors>& y, double sd_s);

/// What rows that are so late, s, add to the residual, to the second order.
[[nodiscard]] Series3 effect_of_lateness(const Signals& s, Sensor k, const Series& late_s);

}  // namespace stillpoint::diag
