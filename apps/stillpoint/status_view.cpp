#include "apps/stillpoint/status_view.h"

#include <fmt/format.h>

#include "apps/stillpoint/live_words.h"
#include "io/quote.h"

namespace stillpoint::app {
namespace {

std::string duration(double s) {
  if (s < 120) return fmt::format("{:.0f} s", s);
  if (s < 7200) return fmt::format("{:.0f} min", s / 60);
  return fmt::format("{:.1f} h", s / 3600);
}

std::array<const SensorHealth*, 3> sensors(const SensorsHealth& h) { return {&h.acc, &h.gyr, &h.mag}; }

std::string sensor_lines(const DiagnosticsMessage& d, const CalibrationMessage& calibration) {
  std::string out = "sensor  health                  calibration\n";
  const auto triad = triads(calibration.snapshot);
  const auto health = sensors(d.health);
  for (std::size_t i = 0; i < triad.size(); ++i) {
    const TriadCalibration& c = *triad[i];
    out += fmt::format("  {}   {:<22}  {}, {} windows, bias {}\n", kSensorName[i], health_words(*health[i]),
                       word(c.status), c.windows, bias_words(c, i, 3));
    if (!calibration.reasons[i].empty()) out += fmt::format("        {}\n", io::printable(calibration.reasons[i]));
  }
  return out + fmt::format("  temp  {:<22}  {}\n", health_words(d.health.temp),
                           std::isfinite(d.temp_degC) ? fmt::format("{:.1f} degC", d.temp_degC) : "not measured");
}

std::string attitude_line(const AttitudeMessage& m) {
  const Vec3 rpy = kDegPerRad * roll_pitch_yaw(m.q_world_body_xyzw);
  const auto& s = m.sigma_rpy_rad;
  return fmt::format("attitude  roll {:.2f} +- {:.2f}  pitch {:.2f} +- {:.2f}  yaw {:.2f} +- {:.2f} deg, {}\n", rpy.x(),
                     kDegPerRad * s[0], rpy.y(), kDegPerRad * s[1], rpy.z(), kDegPerRad * s[2],
                     m.at_rest ? "at rest" : "moving");
}

}  // namespace

std::string status_text(const WatchState& state) {
  const DiagnosticsMessage& d = *state.diagnostics;
  std::string out = fmt::format("stillpointd  {}  sensor {}  heading {}  up {}\n", name(d.status),
                                d.sensor_id.empty() ? "-" : io::printable(d.sensor_id), name(d.heading_reference),
                                duration(d.uptime_s));
  out += fmt::format("source    {}, {:.1f} Hz{}\n", io::printable(d.source), d.rate_hz,
                     d.expected_rate_hz > 0 ? fmt::format(" of {:.1f}", d.expected_rate_hz) : "");
  out += fmt::format("samples   {}  gaps {} (longest {:.2f} s)  refused {}  not finite {}  clipped {}  dropped {}\n",
                     d.samples, d.gaps, d.longest_gap_s, d.refused, d.not_finite, d.clipped, d.dropped);
  out += fmt::format("latency   p50 {:.0f} us  p99 {:.0f} us  max {:.0f} us from arrival to write\n",
                     percentile_us(d.latency_counts, 0.5), percentile_us(d.latency_counts, 0.99),
                     1e-3 * static_cast<double>(d.latency_max_ns));
  if (state.attitude) out += attitude_line(*state.attitude);
  out += sensor_lines(d, *state.calibration);
  out += fmt::format("rest      {}{}\n", io::printable(d.message),
                     d.last_refusal.empty() ? "" : "; last refused: " + io::printable(d.last_refusal));
  out += fmt::format("network   datagrams refused: {} malformed, {} from elsewhere, {} of a flood; failed writes {}\n",
                     d.datagrams_malformed, d.datagrams_off_host, d.datagrams_flooded, d.write_failures);
  return out + fmt::format("trouble   {}\n", d.missing.empty() ? "none" : io::printable(d.missing));
}

namespace {

nlohmann::json health_json(const SensorHealth& h) {
  return {
      {"state", name(h.state)}, {"fault", name(h.fault)}, {"since_ns", h.since_ns}, {"evidence", number(h.evidence)}};
}

nlohmann::json sensor_json(const SensorHealth& health, const TriadCalibration& c, const std::string& reason) {
  return {{"health", health_json(health)},
          {"calibration",
           {{"status", word(c.status)},
            {"reason", reason},
            {"windows", c.windows},
            {"bias", numbers(c.bias)},
            {"bias_sd", numbers(bias_sd(c))},
            {"temp_range_degC", numbers(std::array{c.temp_min_degC, c.temp_max_degC})}}}};
}

}  // namespace

nlohmann::json status_json(const WatchState& state) {
  const DiagnosticsMessage& d = *state.diagnostics;
  const CalibrationMessage& c = *state.calibration;
  const auto triad = triads(c.snapshot);
  const auto health = sensors(d.health);
  nlohmann::json out{{"schema", "stillpoint.status/1"},
                     {"status", name(d.status)},
                     {"heading_reference", name(d.heading_reference)},
                     {"health", name(d.health.worst())},
                     {"sensor_id", d.sensor_id},
                     {"uptime_s", number(d.uptime_s)},
                     {"source", d.source},
                     {"rate_hz", number(d.rate_hz)},
                     {"expected_rate_hz", number(d.expected_rate_hz)},
                     {"samples", d.samples},
                     {"gaps", d.gaps},
                     {"longest_gap_s", number(d.longest_gap_s)},
                     {"refused", d.refused},
                     {"not_finite", d.not_finite},
                     {"clipped", d.clipped},
                     {"dropped", d.dropped},
                     {"write_failures", d.write_failures},
                     {"calibration_version", c.snapshot.version},
                     {"temperature_degC", number(d.temp_degC)},
                     {"message", d.message},
                     {"last_refusal", d.last_refusal},
                     {"missing", d.missing}};
  out["latency_us"] = {{"p50", percentile_us(d.latency_counts, 0.5)},
                       {"p99", percentile_us(d.latency_counts, 0.99)},
                       {"max", 1e-3 * static_cast<double>(d.latency_max_ns)}};
  out["datagrams_refused"] = {
      {"malformed", d.datagrams_malformed}, {"off_host", d.datagrams_off_host}, {"flooded", d.datagrams_flooded}};
  for (std::size_t i = 0; i < triad.size(); ++i)
    out["sensors"][kSensorName[i]] = sensor_json(*health[i], *triad[i], c.reasons[i]);
  out["sensors"]["temp"] = {{"health", health_json(d.health.temp)}};
  out["attitude"] = nullptr;
  if (state.attitude)
    out["attitude"] = {{"roll_pitch_yaw_rad", numbers(array(roll_pitch_yaw(state.attitude->q_world_body_xyzw)))},
                       {"sigma_rpy_rad", numbers(state.attitude->sigma_rpy_rad)},
                       {"at_rest", state.attitude->at_rest}};
  return out;
}

}  // namespace stillpoint::app
