/// `stillpoint noise`: Allan deviation of a sensor at rest, the noise terms behind it, and the blocks to paste
/// elsewhere.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "apps/stillpoint/commands.h"
#include "io/recording.h"
#include "simulation/allan.h"

namespace stillpoint::app {
namespace {

using sim::AllanPoint;
using sim::NoiseTerms;

struct Options {
  std::string recording, json, kalibr, figure;
};

struct Sensor {
  const char* name;  ///< as in the columns
  const char* key;   ///< as in the simulation YAML
  const char* unit;  ///< of the reading
  const char* noise_key;
  const std::vector<Vec3>* column;
};

struct AxisNoise {
  std::string channel;
  const Sensor* sensor;
  std::vector<AllanPoint> points;
  NoiseTerms terms;
};

/// Rows [first, last) of the longest stretch without motion: one-second blocks whose standard deviation stays within
/// four times that of the quietest quarter.
std::pair<std::size_t, std::size_t> longest_rest(const io::Recording& r, double dt_s) {
  constexpr double kMovingOverQuiet = 4.0;
  const std::vector<Vec3>& x = r.gyr_radps.empty() ? r.acc_mps2 : r.gyr_radps;
  const auto block = static_cast<std::size_t>(std::max(10.0, std::round(1.0 / dt_s)));
  if (x.empty() || r.size() < 4 * block) return {0, r.size()};
  std::vector<double> sd(r.size() / block);
  for (std::size_t b = 0; b < sd.size(); ++b) {
    Vec3 sum = Vec3::Zero(), squares = Vec3::Zero();
    for (std::size_t i = b * block; i < (b + 1) * block; ++i) {
      sum += x[i];
      squares += x[i].cwiseAbs2();
    }
    const double n = static_cast<double>(block);
    sd[b] = std::sqrt(std::max(0.0, (squares / n - (sum / n).cwiseAbs2()).sum()));
  }
  std::vector<double> sorted = sd;
  std::sort(sorted.begin(), sorted.end());
  const double limit = kMovingOverQuiet * sorted[sorted.size() / 4] + 1e-12;
  std::size_t best = 0, best_length = 0, start = 0;
  for (std::size_t b = 0; b <= sd.size(); ++b) {
    if (b < sd.size() && sd[b] <= limit) continue;  // a NaN counts as motion
    if (b - start > best_length) std::tie(best, best_length) = std::pair{start, b - start};
    start = b + 1;
  }
  if (best_length == sd.size()) return {0, r.size()};
  return {best * block, (best + best_length) * block};
}

std::string with_error(const NoiseTerms& t, sim::NoiseKind kind) {
  if (t.value[kind] > 0) return fmt::format("{:.3g} +- {:.1g}", t.value[kind], 1.96 * t.standard_error[kind]);
  return fmt::format("< {:.2g}", t.upper_limit[kind]);
}

/// Mean over the axes of one sensor; a term that is not there counts as zero.
double mean_term(const std::vector<AxisNoise>& axes, const Sensor& sensor, sim::NoiseKind kind) {
  double sum = 0.0;
  int count = 0;
  for (const AxisNoise& a : axes)
    if (a.sensor == &sensor) {
      sum += a.terms.value[kind];
      ++count;
    }
  return count == 0 ? 0.0 : sum / count;
}

/// The mean, or where no axis shows the term the mean of the upper limits: Kalibr takes no zero.
std::string kalibr_line(const char* key, const char* unit, const std::vector<AxisNoise>& axes, const Sensor& sensor,
                        sim::NoiseKind kind) {
  double value = mean_term(axes, sensor, kind);
  const char* note = "";
  if (value == 0.0) {
    int count = 0;
    for (const AxisNoise& a : axes)
      if (a.sensor == &sensor) value += a.terms.upper_limit[kind], ++count;
    if (count == 0) return "";
    value /= count;
    note = "; upper limit (95 %): record longer to see it";
  }
  return fmt::format("{}: {:.4e}   # {}{}\n", key, value, unit, note);
}

std::string kalibr_yaml(const std::vector<AxisNoise>& axes, const Sensor& acc, const Sensor& gyr, double rate_hz) {
  return "# Continuous-time values as measured at rest; multiply by 5 to 10 for a moving, vibrating platform.\n" +
         kalibr_line("accelerometer_noise_density", "m/s^2/sqrt(Hz)", axes, acc, sim::kWhite) +
         kalibr_line("accelerometer_random_walk", "m/s^3/sqrt(Hz)", axes, acc, sim::kRandomWalk) +
         kalibr_line("gyroscope_noise_density", "rad/s/sqrt(Hz)", axes, gyr, sim::kWhite) +
         kalibr_line("gyroscope_random_walk", "rad/s^2/sqrt(Hz)", axes, gyr, sim::kRandomWalk) +
         fmt::format("update_rate: {:.6g}   # Hz\n", rate_hz);
}

std::string simulation_block(const std::vector<AxisNoise>& axes, const std::vector<Sensor>& sensors, double rate_hz) {
  std::string text = fmt::format("rate_hz: {:.6g}\n", rate_hz);
  for (const Sensor& s : sensors) {
    if (s.column->empty()) continue;
    text += fmt::format("{}: {{bias: [0, 0, 0], matrix: [[1,0,0],[0,1,0],[0,0,1]], {}: {:.4g}", s.key, s.noise_key,
                        mean_term(axes, s, sim::kWhite) * std::sqrt(rate_hz));
    const std::string unit = std::string(s.noise_key).substr(std::string("noise_").size());
    if (const double b = mean_term(axes, s, sim::kInstability); b > 0.0)
      text += fmt::format(", bias_instability_{}: {:.4g}", unit, b);
    if (const double k = mean_term(axes, s, sim::kRandomWalk); k > 0.0)
      text += fmt::format(", random_walk_{}_per_sqrts: {:.4g}", unit, k);
    text += "}\n";
  }
  return text;
}

/// Log-log curves with their 95 % bars and the fitted law, one panel a sensor, as one SVG.
std::string figure_svg(const std::vector<AxisNoise>& axes, const std::vector<Sensor>& sensors) {
  constexpr double kWidth = 420, kHeight = 340, kLeft = 64, kTop = 30, kPlot = 340, kTall = 250;
  constexpr std::array<const char*, 3> kColour{"#c0392b", "#27864a", "#2b6cb0"};
  std::string svg;
  double left = 0;
  for (const Sensor& sensor : sensors) {
    double t0 = 1e300, t1 = 0, d0 = 1e300, d1 = 0;
    for (const AxisNoise& a : axes)
      if (a.sensor == &sensor)
        for (const AllanPoint& p : a.points) {
          t0 = std::min(t0, p.tau_s), t1 = std::max(t1, p.tau_s);
          d0 = std::min(d0, p.deviation), d1 = std::max(d1, p.deviation);
        }
    if (t1 <= t0) continue;
    const double x0 = std::floor(std::log10(t0)), x1 = std::ceil(std::log10(t1));
    const double y0 = std::floor(std::log10(d0)), y1 = std::ceil(std::log10(d1));
    const auto x = [&](double tau) { return left + kLeft + kPlot * (std::log10(tau) - x0) / (x1 - x0); };
    const auto y = [&](double d) { return kTop + kTall * (y1 - std::log10(d)) / (y1 - y0); };
    svg += fmt::format("<text x='{}' y='20' font-weight='bold'>{} [{}]: overlapping Allan deviation</text>\n",
                       left + kLeft, sensor.key, sensor.unit);
    for (double e = x0; e <= x1; ++e)
      svg +=
          fmt::format("<path d='M{0} {1}V{2}' stroke='#ddd'/><text x='{0}' y='{3}' text-anchor='middle'>1e{4}</text>\n",
                      x(std::pow(10, e)), kTop, kTop + kTall, kTop + kTall + 16, e);
    for (double e = y0; e <= y1; ++e)
      svg += fmt::format("<path d='M{0} {1}H{2}' stroke='#ddd'/><text x='{3}' y='{4}' text-anchor='end'>1e{5}</text>\n",
                         left + kLeft, y(std::pow(10, e)), left + kLeft + kPlot, left + kLeft - 6,
                         y(std::pow(10, e)) + 4, e);
    svg += fmt::format("<text x='{}' y='{}' text-anchor='middle'>averaging time, s</text>\n", left + kLeft + kPlot / 2,
                       kTop + kTall + 34);
    std::size_t k = 0;
    for (const AxisNoise& a : axes) {
      if (a.sensor != &sensor) continue;
      std::string law, bars;
      for (const AllanPoint& p : a.points) {
        const double low = std::max(p.deviation * (1 - 1.96 * p.relative_error), std::pow(10, y0));
        const double high = std::min(p.deviation * (1 + 1.96 * p.relative_error), std::pow(10, y1));
        bars += fmt::format("M{0:.1f} {1:.1f}V{2:.1f}M{3:.1f} {4:.1f}h4", x(p.tau_s), y(low), y(high), x(p.tau_s) - 2,
                            y(p.deviation));
        law += fmt::format("{}{:.1f} {:.1f}", law.empty() ? "M" : "L", x(p.tau_s),
                           y(std::max(sim::predicted_deviation(a.terms, p.tau_s), std::pow(10, y0))));
      }
      svg += fmt::format("<path d='{}' stroke='{}'/><path d='{}' stroke='{}' stroke-dasharray='4 3' fill='none'/>\n",
                         bars, kColour[k], law, kColour[k]);
      svg += fmt::format("<text x='{}' y='{}' fill='{}'>{}</text>\n", left + kLeft + kPlot - 40,
                         kTop + 16 + 14 * static_cast<double>(k), kColour[k], a.channel);
      ++k;
    }
    left += kWidth;
  }
  return fmt::format(
      "<svg xmlns='http://www.w3.org/2000/svg' width='{}' height='{}' font-family='sans-serif' font-size='11'>\n"
      "<rect width='100%' height='100%' fill='white'/>\n{}<text x='{}' y='{}'>bars: 95 % confidence; dashed: the "
      "fitted "
      "terms</text></svg>\n",
      std::max(left, kWidth), kHeight, svg, kLeft, kHeight - 4);
}

int write_text(const std::string& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary);
  file << text;
  file.close();
  if (!file) return report({ErrorKind::kCannotCreate, fmt::format("{}: cannot be written", path)});
  std::fprintf(stderr, "wrote %s\n", path.c_str());
  return 0;
}

nlohmann::json to_json(const std::vector<AxisNoise>& axes, double rate_hz, double seconds) {
  nlohmann::json channels = nlohmann::json::array();
  for (const AxisNoise& a : axes) {
    nlohmann::json curve = nlohmann::json::array();
    for (const AllanPoint& p : a.points)
      curve.push_back({{"tau_s", p.tau_s}, {"deviation", p.deviation}, {"relative_error", p.relative_error}});
    nlohmann::json terms;
    constexpr std::array<const char*, sim::kNoiseKinds> kNames{"quantisation", "white", "bias_instability",
                                                               "random_walk"};
    for (std::size_t k = 0; k < sim::kNoiseKinds; ++k)
      terms[kNames[k]] = {{"value", a.terms.value[k]},
                          {"ci95_half_width", 1.96 * a.terms.standard_error[k]},
                          {"upper_limit_95", a.terms.upper_limit[k]}};
    channels.push_back({{"channel", a.channel}, {"unit", a.sensor->unit}, {"terms", terms}, {"allan", curve}});
  }
  return {{"schema", "stillpoint.noise/1"}, {"rate_hz", rate_hz}, {"seconds", seconds}, {"channels", channels}};
}

int noise(const Options& options) {
  const auto recording = io::read_recording(options.recording);
  if (!recording) return report(recording.error());
  const double dt_s = recording->median_step_s();
  const auto [first, last] = longest_rest(*recording, dt_s);
  const double seconds = static_cast<double>(last - first) * dt_s;
  if (last - first < 100 || dt_s <= 0)
    return report({ErrorKind::kBadData, fmt::format("{}: the longest stretch at rest has {} samples; at least 100 are "
                                                    "needed, an hour serves bias instability",
                                                    options.recording, last - first)});
  if (last - first < recording->size())
    std::fprintf(stderr, "notice: the recording moves; only its longest rest, %.1f s to %.1f s, is used\n",
                 recording->t_s(first) - recording->t_s(0), recording->t_s(last - 1) - recording->t_s(0));

  const std::vector<Sensor> sensors{
      {"acc", "accelerometer", "m/s^2", "noise_mps2", &recording->acc_mps2},
      {"gyr", "gyroscope", "rad/s", "noise_radps", &recording->gyr_radps},
      {"mag", "magnetometer", "uT", "noise_uT", &recording->mag_uT},
  };
  std::vector<AxisNoise> axes;
  std::vector<double> x;
  for (const Sensor& sensor : sensors)
    for (Eigen::Index axis = 0; axis < 3 && !sensor.column->empty(); ++axis) {
      x.clear();
      for (std::size_t i = first; i < last; ++i)
        if (const double v = (*sensor.column)[i][axis]; std::isfinite(v)) x.push_back(v);
      // A slower sensor has fewer readings in the same time: its own step.
      const double step_s = x.empty() ? dt_s : seconds / static_cast<double>(x.size());
      AxisNoise a{fmt::format("{}_{}", sensor.name, "xyz"[axis]), &sensor, sim::allan_deviation(x, step_s), {}};
      a.terms = sim::fit_noise_terms(a.points);
      axes.push_back(std::move(a));
    }

  if (options.json == "-") {
    std::printf("%s\n", to_json(axes, 1.0 / dt_s, seconds).dump(1).c_str());
  } else {
    std::printf("%-7s %-8s %-22s %-22s %-22s %-22s\n", "channel", "unit", "white [unit/sqrt(Hz)]",
                "instability B [unit]", "random walk [unit/sqrt(s)]", "quantisation [unit s]");
    for (const AxisNoise& a : axes)
      std::printf("%-7s %-8s %-22s %-22s %-26s %-22s\n", a.channel.c_str(), a.sensor->unit,
                  with_error(a.terms, sim::kWhite).c_str(), with_error(a.terms, sim::kInstability).c_str(),
                  with_error(a.terms, sim::kRandomWalk).c_str(), with_error(a.terms, sim::kQuantisation).c_str());
    std::printf("\n+- and < are 95 %%; from %.1f s at %.6g Hz\n\n# simulation block\n%s\n# Kalibr imu.yaml\n%s",
                seconds, 1.0 / dt_s, simulation_block(axes, sensors, 1.0 / dt_s).c_str(),
                kalibr_yaml(axes, sensors[0], sensors[1], 1.0 / dt_s).c_str());
    if (!options.json.empty())
      if (const int code = write_text(options.json, to_json(axes, 1.0 / dt_s, seconds).dump(1) + "\n")) return code;
  }
  if (!options.kalibr.empty())
    if (const int code = write_text(options.kalibr, kalibr_yaml(axes, sensors[0], sensors[1], 1.0 / dt_s))) return code;
  return options.figure.empty() ? 0 : write_text(options.figure, figure_svg(axes, sensors));
}

}  // namespace

void add_noise(CLI::App& app, Run& run) {
  auto* command = app.add_subcommand("noise", "Allan deviation and noise terms of a sensor at rest");
  static Options options;
  command->add_option("--recording", options.recording, "recording of the sensor at rest (.csv)")->required();
  command->add_option("--json", options.json, "write the curves and terms as JSON ('-': standard output)");
  command->add_option("--kalibr", options.kalibr, "write a Kalibr imu.yaml");
  command->add_option("--figure", options.figure, "write the log-log figure (.svg)");
  command->callback([&run] { run = [] { return noise(options); }; });
}

}  // namespace stillpoint::app
