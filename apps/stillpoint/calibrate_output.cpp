#include "apps/stillpoint/calibrate_output.h"

#include <fmt/format.h>

#include "io/triad_factory.h"
#include "io/yaml.h"

namespace stillpoint::app {
namespace {

std::string triad_yaml(const char* name, const char* unit, const TriadCalibration& t) {
  return fmt::format("  {}:  # {}; {}, {} pieces of evidence\n", name, unit, stillpoint::name(t.status), t.windows) +
         io::format_fields({.bias = vec(t.bias),
                            .bias_per_K = vec(t.bias_per_K),
                            .bias_per_K2 = vec(t.bias_per_K2),
                            .matrix = mat(t.matrix),
                            .temp_ref_degC = t.temp_ref_degC,
                            .temp_min_degC = t.temp_min_degC,
                            .temp_max_degC = t.temp_max_degC});
}

}  // namespace

std::string sensor_yaml(const std::string& sensor_id, const CalibrationSnapshot& learnt, bool has_mag) {
  std::string out = fmt::format("sensor:\n  id: {}\n", io::yaml_text(sensor_id));
  out += triad_yaml("accelerometer", "m/s^2", learnt.acc);
  out += triad_yaml("gyroscope", "rad/s", learnt.gyr);
  if (has_mag) out += triad_yaml("magnetometer", "uT", learnt.mag);
  return out;
}

}  // namespace stillpoint::app
