/// `stillpoint noise`: Allan deviation of a sensor at rest and the noise terms behind it.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "apps/stillpoint/commands.h"
#include "apps/stillpoint/json_text.h"
#include "apps/stillpoint/noise_report.h"
#include "apps/stillpoint/options.h"
#include "apps/stillpoint/outcome.h"
#include "apps/stillpoint/plausible.h"
#include "io/recording.h"
#include "io/text_file.h"

namespace stillpoint::app {
namespace {

struct NoiseOptions {
  std::string recording, kalibr, report;
  JsonOption json;
};

/// Rows [first, last) of the longest stretch without motion: one-second blocks whose standard deviation stays within
/// four times that of the quietest quarter. Pre: dt_s > 0.
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

nlohmann::json to_json(const std::vector<SensorNoise>& sensors, double rate_hz, double seconds) {
  constexpr std::array<const char*, sim::kNoiseKinds> kNames{"quantisation", "white", "bias_instability",
                                                             "random_walk"};
  nlohmann::json channels = nlohmann::json::array();
  for (const SensorNoise& s : sensors)
    for (const AxisNoise& a : s.axes) {
      nlohmann::json curve = nlohmann::json::array(), terms;
      for (const sim::AllanPoint& p : a.points)
        curve.push_back({{"tau_s", p.tau_s}, {"deviation", p.deviation}, {"relative_error", p.relative_error}});
      for (std::size_t k = 0; k < sim::kNoiseKinds; ++k)
        terms[kNames[k]] = {{"value", a.terms.value[k]},
                            {"ci95_half_width", 1.96 * a.terms.standard_error[k]},
                            {"upper_limit_95", a.terms.upper_limit[k]}};
      channels.push_back({{"channel", a.channel}, {"unit", s.unit}, {"terms", terms}, {"allan", curve}});
    }
  return {{"schema", "stillpoint.noise/1"}, {"rate_hz", rate_hz}, {"seconds", seconds}, {"channels", channels}};
}

/// A slower sensor has fewer readings in the same time: its own step.
SensorNoise noise_of(SensorNoise sensor, const std::vector<Vec3>& column, std::size_t first, std::size_t last,
                     double seconds) {
  std::vector<double> x;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    x.clear();
    for (std::size_t i = first; i < last; ++i)
      if (const double v = column[i][axis]; std::isfinite(v)) x.push_back(v);
    if (x.empty()) continue;
    sensor.rate_hz = static_cast<double>(x.size()) / seconds;
    AxisNoise a{fmt::format("{}_{}", sensor.name, "xyz"[axis]), sim::allan_deviation(x, 1.0 / sensor.rate_hz), {}};
    a.terms = sim::fit_noise_terms(a.points);
    sensor.axes.push_back(std::move(a));
  }
  return sensor;
}

std::vector<SensorNoise> sensors_at_rest(const io::Recording& r, std::size_t first, std::size_t last, double seconds) {
  std::vector<SensorNoise> out;
  const auto add = [&](SensorNoise sensor, const std::vector<Vec3>& column) {
    if (column.empty()) return;
    if (auto noise = noise_of(std::move(sensor), column, first, last, seconds); !noise.axes.empty())
      out.push_back(std::move(noise));
  };
  add({"acc", "accelerometer", "m/s^2", "mps2"}, r.acc_mps2);
  add({"gyr", "gyroscope", "rad/s", "radps"}, r.gyr_radps);
  add({"mag", "magnetometer", "uT", "uT"}, r.mag_uT);
  return out;
}

int noise(const NoiseOptions& options) {
  const auto quiet = is_standard_output({options.json.file(), options.kalibr, options.report});
  if (!quiet) return report(quiet.error());
  const auto recording = io::read_recording(options.recording);
  if (!recording) return report(recording.error());
  warn_if_implausible(*recording, options.recording);
  const double dt_s = recording->median_step_s();
  const auto [first, last] = dt_s > 0.0 ? longest_rest(*recording, dt_s) : std::pair<std::size_t, std::size_t>{};
  if (last - first < 100)
    return report({ErrorKind::kBadData, fmt::format("{}: the longest stretch at rest has {} samples; at least 100 are "
                                                    "needed, an hour serves bias instability",
                                                    options.recording, last - first)});
  const double seconds = static_cast<double>(last - first) * dt_s, rate_hz = 1.0 / dt_s;
  if (last - first < recording->size())
    tell(fmt::format("notice: the recording moves; only its longest rest, {:.1f} s to {:.1f} s, is used",
                     recording->t_s(first) - recording->t_s(0), recording->t_s(last - 1) - recording->t_s(0)));
  const auto sensors = sensors_at_rest(*recording, first, last, seconds);
  if (sensors.empty())
    return report(
        {ErrorKind::kBadData, fmt::format("{}: no acc, gyr or mag columns with readings at rest", options.recording)});
  const std::string json = json_text(to_json(sensors, rate_hz, seconds), 1), kalibr = kalibr_yaml(sensors, rate_hz);
  if (!*quiet)
    std::printf("%s\n+- and < are 95 %%; from %.1f s at %.6g Hz\n\n# simulation block\n%s\n# Kalibr imu.yaml\n%s",
                noise_table(sensors).c_str(), seconds, rate_hz, noise_simulation_block(sensors, rate_hz).c_str(),
                kalibr.c_str());
  const auto write = [](const std::string& path, const std::string& text) {
    if (path.empty()) return 0;
    if (const auto done = io::write_text_file(path, text); !done) return report(done.error());
    if (path != "-") tell("wrote " + path);
    return 0;
  };
  if (const int code = write(options.json.file(), json)) return code;
  if (const int code = write(options.kalibr, kalibr)) return code;
  return options.report.empty() ? 0 : write(options.report, noise_html(options.recording, sensors, rate_hz, seconds));
}

}  // namespace

void add_noise(CLI::App& app, Run& run) {
  auto* command = app.add_subcommand("noise", "Allan deviation and noise terms of a sensor at rest");
  static NoiseOptions options;
  add_file(*command, "--recording", options.recording, "recording of the sensor at rest (.csv)")->required();
  options.json.add(*command, "write the curves and terms");
  add_file(*command, "--kalibr", options.kalibr, "write a Kalibr imu.yaml");
  add_file(*command, "--report", options.report, "write terms and curves as a page (.html)");
  command->callback([&run] { run = [] { return noise(options); }; });
}

}  // namespace stillpoint::app
