// The catalogue of effects as the page docs/effects.md, which `stillpoint effects` prints.
#include <cstdio>

#include "simulation/effect_catalogue.h"

namespace stillpoint::sim {
namespace {

std::string short_number(double x) {
  char text[32];
  std::snprintf(text, sizeof(text), "%g", x);
  return text;
}

std::string parameter_line(const EffectParameter& p) {
  const std::string count = p.count == 9 ? "3x3" : p.count == 3 ? "x, y, z" : "one number";
  std::string line = "| `" + p.key + "` | " + p.symbol + " | " + count + " | " + p.unit + " | ";
  if (!p.required) return line + "not needed; " + short_number(p.fallback) + " |\n";
  if (p.typical_high == 0.0) return line + "needed |\n";
  return line + "needed; usually " + short_number(p.typical_low) + " to " + short_number(p.typical_high) + " |\n";
}

std::string entry(const EffectInfo& e) {
  std::string out = "### `" + e.id + "` (" + e.entry + "): " + e.title + "\n\n";
  out += "    " + e.equation + "\n\n";
  out += "Driver: " + e.driver + ". Excited by " + e.excited_by + ". Mistaken for " + e.mistaken_for +
         ". Told apart by: " + e.told_apart_by + ".\n\n";
  out += "| key | symbol | numbers | unit | value |\n|---|---|---|---|---|\n";
  for (const auto& p : e.parameters) out += parameter_line(p);
  return out + "\n";
}

}  // namespace

std::string effect_catalogue_page() {
  std::string out =
      "# The effects\n\n"
      "Printed by `stillpoint effects` from the catalogue in `simulation/effects_of_*.cpp`; a test holds this page to "
      "it.\n\n"
      "In a simulation YAML an effect is one entry of the list `effects:`, for example\n"
      "`{effect: gyr_temp_lin, k_radps_per_K: [4e-4, 0, -2e-4], axes: [x, z], window_s: [10, 60]}`. Any effect may "
      "have\n"
      "`axes` (of its sensor; without it all) and `window_s` (from the start of the recording; without it always). An\n"
      "effect on the whole sensor block, `sys_*` but for `sys_tracker`, and `ref_frame`, may also name the `sensors` "
      "it\n"
      "acts on (`[acc, gyr]`; without it all). A delay or a clock fault on some axes leaves the others on time: "
      "converters\n"
      "of their own. Axes of `ref_error` are the body's for its orientation and the world's for its position. Where x, "
      "y, z are due,\n"
      "one number serves all three; 3x3 numbers are written row by row.\n\n"
      "Symbols: `u = H (y - B)` is the corrected reading, `D` what the effect adds to the true vector in the sensor "
      "frame;\n"
      "`f` specific force, `w` body rate, `m` field, `p` position, `R` body to world, `T - T0` temperature against 25 "
      "degC,\n"
      "`I` current, `V - V0` supply against 3.7 V, `fs` sampling rate, `*` elementwise, `x` cross product, `'` "
      "transposed.\n";
  std::string sensor;
  const auto heading = [](const std::string& s) {
    return s == "acc"   ? "Accelerometer"
           : s == "gyr" ? "Gyroscope"
           : s == "mag" ? "Magnetometer"
           : s == "sys" ? "System"
                        : "Reference";
  };
  for (const auto& e : effect_catalogue()) {
    if (e.sensor != sensor) out += std::string("\n## ") + heading(e.sensor) + "\n\n";
    sensor = e.sensor;
    out += entry(e);
  }
  return out;
}

}  // namespace stillpoint::sim
