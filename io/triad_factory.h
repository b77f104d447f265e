/// What is known of a sensor before it is used: the calibration of one triad as the daemon's `sensor:` holds it.
#pragma once
#include <string>

#include "core/fields.h"
#include "core/types.h"

namespace stillpoint::io {

/// u = matrix * (reading - bias(T)), bias(T) = bias + bias_per_K t + bias_per_K2 t^2 with t = T - temp_ref_degC, in the
/// unit of the reading (m/s^2, rad/s, uT).
struct TriadFactory {
  Vec3 bias = Vec3::Zero(), bias_per_K = Vec3::Zero(), bias_per_K2 = Vec3::Zero();
  Mat3 matrix = Mat3::Identity();
  double temp_ref_degC = 25.0, temp_min_degC = 25.0, temp_max_degC = 25.0;
  template <class P = TriadFactory>
  static constexpr auto fields() {
    constexpr Range kTemperature = in_range(-200.0, 500.0);
    return std::tuple{
        field("bias", &P::bias, "in the unit of the reading, at temp_ref_degC"),
        field("bias_per_K", &P::bias_per_K, "what a kelvin adds to it"),
        field("bias_per_K2", &P::bias_per_K2, "and its square"),
        field("temp_ref_degC", &P::temp_ref_degC, kTemperature, "from where the kelvins are counted"),
        field("temp_min_degC", &P::temp_min_degC, kTemperature, "coldest temperature that this was seen at"),
        field("temp_max_degC", &P::temp_max_degC, kTemperature, "warmest; nothing is extrapolated beyond the two"),
        field("matrix", &P::matrix, "three rows; u = matrix * (reading - bias)")};
  }
};

/// As YAML behind "  accelerometer:", each line indented by four.
[[nodiscard]] std::string format_fields(const TriadFactory& triad);

}  // namespace stillpoint::io
