#include "apps/stillpoint/calibrate_output.h"

#include <fmt/format.h>

#include <span>

namespace stillpoint::app {
namespace {

std::string list(std::span<const double> v) { return fmt::format("[{}]", fmt::join(v, ", ")); }

std::string quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("''") : std::string(1, c);
  return out + "'";
}

std::string triad_yaml(const char* name, const char* unit, const TriadCalibration& t) {
  const std::span<const double> m(t.matrix);
  return fmt::format(
      "  {}:  # {}; {}, {} pieces of evidence\n    bias: {}\n    bias_per_K: {}\n    bias_per_K2: {}\n"
      "    temp_ref_degC: {}\n    temp_min_degC: {}\n    temp_max_degC: {}\n    matrix: [{}, {}, {}]\n",
      name, unit, stillpoint::name(t.status), t.windows, list(t.bias), list(t.bias_per_K), list(t.bias_per_K2),
      t.temp_ref_degC, t.temp_min_degC, t.temp_max_degC, list(m.subspan(0, 3)), list(m.subspan(3, 3)),
      list(m.subspan(6, 3)));
}

}  // namespace

std::string sensor_yaml(const std::string& sensor_id, const CalibrationSnapshot& learnt, bool has_mag) {
  std::string out = fmt::format("sensor:\n  id: {}\n", quoted(sensor_id));
  out += triad_yaml("accelerometer", "m/s^2", learnt.acc);
  out += triad_yaml("gyroscope", "rad/s", learnt.gyr);
  if (has_mag) out += triad_yaml("magnetometer", "uT", learnt.mag);
  return out;
}

}  // namespace stillpoint::app
