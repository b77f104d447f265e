/// What `watch` and `status` share: the words and numbers of a running daemon's messages, for people and as JSON.
#pragma once
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "core/attitude_message.h"
#include "core/units.h"

namespace stillpoint::app {

inline constexpr std::array kSensorName{"acc", "gyr", "mag"};
inline constexpr std::array kSensorUnit{"m/s^2", "deg/s", "uT"};

/// From the wire any number may come.
inline std::string_view word(CalibrationStatus status) {
  return status <= CalibrationStatus::kReplaced ? name(status) : "unknown";
}

inline std::string health_words(const SensorHealth& h) {
  if (h.fault == Fault::kNone) return std::string(name(h.state));
  return std::string(name(h.state)) + ": " + std::string(name(h.fault));
}

/// Roll, pitch, yaw (rad) in the order z, y, x of REP-103; yaw 0 is east, counter-clockwise positive.
inline Vec3 roll_pitch_yaw(const std::array<double, 4>& xyzw) {
  const auto [x, y, z, w] = xyzw;
  return {std::atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)),
          std::asin(std::clamp(2 * (w * y - z * x), -1.0, 1.0)),
          std::atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))};
}

inline double percentile_us(const LatencyCounts& counts, double p) {
  return 1e-3 * static_cast<double>(latency_percentile_ns(counts, p));
}

/// NaN where unknown, which the message says by zeros.
inline Array3 bias_sd(const TriadCalibration& c) {
  Array3 sd;
  for (std::size_t i = 0; i < sd.size(); ++i) {
    const double variance = c.bias_covariance[4 * i];
    sd[i] = variance > 0.0 ? std::sqrt(variance) : std::numeric_limits<double>::quiet_NaN();
  }
  return sd;
}

/// Of the sensor of that index, in its unit: "0.012 -0.340 0.005 +- 0.002 0.002 0.003 deg/s".
inline std::string bias_words(const TriadCalibration& c, std::size_t sensor, int decimals) {
  const double scale = sensor == 1 ? kDegPerRad : 1.0;
  const auto words = [&](const Array3& x) {
    return fmt::format("{:.{}f} {:.{}f} {:.{}f}", scale * x[0], decimals, scale * x[1], decimals, scale * x[2],
                       decimals);
  };
  const Array3 sd = bias_sd(c);
  const bool known = std::all_of(sd.begin(), sd.end(), [](double x) { return std::isfinite(x); });
  return fmt::format("{} +- {} {}", words(c.bias), known ? words(sd) : "(not known yet)", kSensorUnit[sensor]);
}

inline std::array<const TriadCalibration*, 3> triads(const CalibrationSnapshot& s) { return {&s.acc, &s.gyr, &s.mag}; }

/// JSON knows no NaN.
inline nlohmann::json number(double x) { return std::isfinite(x) ? nlohmann::json(x) : nlohmann::json(nullptr); }
template <std::size_t N>
nlohmann::json numbers(const std::array<double, N>& values) {
  auto list = nlohmann::json::array();
  for (const double x : values) list.push_back(number(x));
  return list;
}

}  // namespace stillpoint::app
