/// A WatchState as JSON for scripts.
#include <array>

#include "apps/stillpoint/live_words.h"
#include "apps/stillpoint/watch_model.h"

namespace stillpoint::app {
namespace {

nlohmann::json calibration_json(const CalibrationMessage& message) {
  auto sensors = nlohmann::json::array();
  const auto all = triads(message.snapshot);
  for (std::size_t i = 0; i < 3; ++i) {
    const TriadCalibration& c = *all[i];
    sensors.push_back({{"sensor", kSensorName[i]},
                       {"status", word(c.status)},
                       {"reason", message.reasons[i]},
                       {"windows", c.windows},
                       {"bias", numbers(c.bias)},
                       {"bias_per_K", numbers(c.bias_per_K)},
                       {"bias_per_K2", numbers(c.bias_per_K2)},
                       {"bias_sd", numbers(bias_sd(c))},
                       {"matrix", numbers(c.matrix)},
                       {"norm_sd", number(c.norm_sd)},
                       {"temp_ref_degC", number(c.temp_ref_degC)},
                       {"temp_range_degC", numbers(std::array{c.temp_min_degC, c.temp_max_degC})}});
  }
  return {{"version", message.snapshot.version}, {"sensor_id", message.sensor_id}, {"sensors", sensors}};
}

nlohmann::json attitude_json(const AttitudeMessage& m) {
  return {{"t_ns", m.t_ns},
          {"sequence", m.sequence},
          {"orientation_xyzw", numbers(m.q_world_body_xyzw)},
          {"roll_pitch_yaw_rad", numbers(array(roll_pitch_yaw(m.q_world_body_xyzw)))},
          {"sigma_rpy_rad", numbers(m.sigma_rpy_rad)},
          {"orientation_covariance_rad2", numbers(m.orientation_covariance_rad2)},
          {"rate_radps", numbers(m.rate_radps)},
          {"gyro_bias_radps", numbers(m.gyro_bias_radps)},
          {"at_rest", m.at_rest},
          {"status", name(m.status)},
          {"heading_reference", name(m.heading_reference)},
          {"temperature_degC", number(m.temp_degC)},
          {"calibration_version", m.calibration_version}};
}

nlohmann::json diagnostics_json(const DiagnosticsMessage& d) {
  return {{"uptime_s", number(d.uptime_s)},
          {"rate_hz", number(d.rate_hz)},
          {"expected_rate_hz", number(d.expected_rate_hz)},
          {"samples", d.samples},
          {"clipped", d.clipped},
          {"refused", d.refused},
          {"longest_gap_s", number(d.longest_gap_s)},
          {"write_failures", d.write_failures},
          {"message", d.message},
          {"last_refusal", d.last_refusal},
          {"processing_us",
           {{"p50", percentile_us(d.latency_counts, 0.5)},
            {"p99", percentile_us(d.latency_counts, 0.99)},
            {"max", 1e-3 * static_cast<double>(d.latency_max_ns)}}}};
}

}  // namespace

nlohmann::json json_view(const WatchState& s) {
  nlohmann::json out{{"schema", "stillpoint.watch/1"},
                     {"received", s.received},
                     {"lost", s.lost},
                     {"restarts", s.restarts},
                     {"rate_hz", number(s.rate_hz)},
                     {"age_s", number(s.age_s)},
                     {"latency_us",
                      {{"p50", percentile_us(s.latency_counts, 0.5)},
                       {"p90", percentile_us(s.latency_counts, 0.9)},
                       {"p99", percentile_us(s.latency_counts, 0.99)},
                       {"max", 1e-3 * static_cast<double>(s.latency_max_ns)}}}};
  out["attitude"] = s.attitude ? attitude_json(*s.attitude) : nlohmann::json(nullptr);
  out["source_gaps"] = s.attitude ? nlohmann::json(s.attitude->gaps) : nlohmann::json(nullptr);
  out["dropped"] = s.attitude ? nlohmann::json(s.attitude->dropped) : nlohmann::json(nullptr);
  out["calibration"] = s.calibration ? calibration_json(*s.calibration) : nlohmann::json(nullptr);
  out["diagnostics"] = s.diagnostics ? diagnostics_json(*s.diagnostics) : nlohmann::json(nullptr);
  return out;
}

}  // namespace stillpoint::app
