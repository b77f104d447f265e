// A noise identification as text: the table, the block for a simulation, Kalibr's imu.yaml.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/stillpoint/noise_report.h"

namespace stillpoint::app {
namespace {

std::string with_error(const sim::NoiseTerms& t, sim::NoiseKind kind) {
  if (t.value[kind] > 0) return fmt::format("{:.3g} +- {:.1g}", t.value[kind], 1.96 * t.standard_error[kind]);
  return fmt::format("< {:.2g}", t.upper_limit[kind]);
}

/// Median, or where no axis shows the term the mean of the upper limits: Kalibr takes no zero.
std::string kalibr_line(const std::string& key, const std::string& unit, const SensorNoise& s, sim::NoiseKind kind) {
  double value = s.typical(kind);
  const bool seen = value > 0.0;
  if (!seen)
    for (const AxisNoise& a : s.axes)
      value += std::max(a.terms.value[kind], a.terms.upper_limit[kind]) / static_cast<double>(s.axes.size());
  return fmt::format("{}: {:.4e}   # {}{}\n", key, value, unit,
                     seen ? "" : "; upper limit (95 %): record longer to see it");
}

/// ", noise_axes: [...]" where the axes differ by more than their errors and by more than 3 %.
std::string unequal_axes(const SensorNoise& s) {
  const double typical = s.typical(sim::kWhite);
  bool differ = false;
  std::string list;
  for (const AxisNoise& a : s.axes) {
    const double off = std::abs(a.terms.value[sim::kWhite] - typical);
    differ = differ || (off > 0.03 * typical && off > 3.0 * a.terms.standard_error[sim::kWhite]);
    list += fmt::format("{}{:.3g}", list.empty() ? "" : ", ", a.terms.value[sim::kWhite] / typical);
  }
  return differ ? fmt::format(", noise_axes: [{}]", list) : "";
}

}  // namespace

double SensorNoise::typical(sim::NoiseKind kind) const {
  std::vector<double> values;
  for (const AxisNoise& a : axes) values.push_back(a.terms.value[kind]);
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

std::string noise_table(const std::vector<SensorNoise>& sensors) {
  std::string out = fmt::format("{:<7} {:<8} {:<22} {:<22} {:<26} {:<22}\n", "channel", "unit", "white [unit/sqrt(Hz)]",
                                "instability B [unit]", "random walk [unit/sqrt(s)]", "quantisation [unit s]");
  for (const SensorNoise& s : sensors)
    for (const AxisNoise& a : s.axes)
      out += fmt::format("{:<7} {:<8} {:<22} {:<22} {:<26} {:<22}\n", a.channel, s.unit,
                         with_error(a.terms, sim::kWhite), with_error(a.terms, sim::kInstability),
                         with_error(a.terms, sim::kRandomWalk), with_error(a.terms, sim::kQuantisation));
  return out;
}

std::string kalibr_yaml(const std::vector<SensorNoise>& sensors, double rate_hz) {
  std::string out =
      "# Continuous-time values as measured at rest; multiply by 5 to 10 for a moving, vibrating platform.\n";
  for (const SensorNoise& s : sensors) {
    if (s.name == "mag") continue;  // Kalibr calibrates accelerometer and gyroscope
    out += kalibr_line(s.key + "_noise_density", s.unit + "/sqrt(Hz)", s, sim::kWhite);
    const std::string rate_of_change = s.name == "acc" ? "m/s^3" : "rad/s^2";
    out += kalibr_line(s.key + "_random_walk", rate_of_change + "/sqrt(Hz)", s, sim::kRandomWalk);
  }
  return out + fmt::format("update_rate: {:.6g}   # Hz\n", rate_hz);
}

std::string noise_simulation_block(const std::vector<SensorNoise>& sensors, double rate_hz) {
  std::string out = fmt::format("rate_hz: {:.6g}\n", rate_hz);
  for (const SensorNoise& s : sensors) {
    out += fmt::format("{}: {{noise_{}: {:.4g}{}", s.key, s.suffix, s.typical(sim::kWhite) * std::sqrt(s.rate_hz),
                       unequal_axes(s));
    if (const double b = s.typical(sim::kInstability); b > 0.0)
      out += fmt::format(", bias_instability_{}: {:.4g}", s.suffix, b);
    if (const double k = s.typical(sim::kRandomWalk); k > 0.0)
      out += fmt::format(", random_walk_{}_per_sqrts: {:.4g}", s.suffix, k);
    if (s.rate_hz < 0.95 * rate_hz) out += fmt::format(", rate_hz: {:.6g}", s.rate_hz);
    out += "}\n";
  }
  return out;
}

}  // namespace stillpoint::app
