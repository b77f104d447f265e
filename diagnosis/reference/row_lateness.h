/// The time of each row, where rows are taken at random times: as all channels tell it together.
#pragma once
#include <array>
#include <vector>

#include "diagnosis/reference/signals.h"

namespace stillpoint::diag {

/// What a sensor saw, as far as it is known, and what its readings deviate from that.
struct Seen {
  Series3 vector, deviation;  ///< empty: the sensor is not compared
};

/// One sensor's rows in motion, in units of its noise.
struct TimedRows {
  Sensor sensor = kAcc;
  std::vector<Eigen::Index> at;
  std::vector<double> along, slope, noise;  ///< residual along the derivative; size of the derivative per s; variance
  Vec3 variance = Vec3::Zero();             ///< of each axis, in the mean over the rows
};

/// What bias, matrix, a delay and smooth curves leave of a sensor's deviation, where rows deviate in time by `sd_s`.
[[nodiscard]] TimedRows rows_of(const Signals& s, Sensor k, const Seen& seen, double sd_s);

/// How late each row is, s, by the deviations of the sensors, which nothing else is in: the likeliest white one of
/// `sd_s`, and the mean that so many of them have.
[[nodiscard]] Series lateness_of(const Signals& s, const std::vector<TimedRows>& sensors,
                                 const std::array<Seen, kSensors>& seen, double sd_s);

/// What rows that are so late, s, add to the readings of this vector, to the second order.
[[nodiscard]] Series3 effect_of_lateness(const Signals& s, const Series3& vector, const Series& late_s);

}  // namespace stillpoint::diag
