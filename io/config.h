/// The daemon's configuration (docs/configuration.md): YAML into the parameter structs of the parts, all faults at
/// once.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "calib_online/online_calibrator.h"
#include "calib_online/rest_detector.h"
#include "core/calibration.h"
#include "core/fields.h"
#include "core/result.h"
#include "fusion/attitude_filter.h"
#include "io/dds_params.h"
#include "io/source_config.h"
#include "io/triad_factory.h"
#include "io/yaml.h"
#include "pipeline/realtime.h"
#include "pipeline/stages.h"
#include "simulation/config.h"

namespace stillpoint::io {

struct SensorConfig {
  std::string id = "imu0";
  TriadFactory accelerometer, gyroscope, magnetometer;
  pipeline::GuardParams limits;
  template <class P = SensorConfig>
  static constexpr auto fields() {
    return std::tuple{
        field("id", &P::id, "identity of this very sensor (serial number): its calibration is kept under it"),
        field("accelerometer", &P::accelerometer, "factory calibration, m/s^2"),
        field("gyroscope", &P::gyroscope, "factory calibration, rad/s"),
        field("magnetometer", &P::magnetometer, "factory calibration, uT"),
        field("limits", &P::limits, "full scales, and what counts as a gap")};
  }
};

struct CalibrationConfig {
  bool enabled = true;
  double answer_delay_s = 0.1;
  calib::OnlineCalibratorParams online;
  template <class P = CalibrationConfig>
  static constexpr auto fields() {
    return std::tuple{
        field("enabled", &P::enabled, "false: the factory calibration serves all the time"),
        field("answer_delay_s", &P::answer_delay_s, in_range(0.0, 10.0),
              "from the end of a rest window to the use of what was learnt from it, in the sensor's time"),
        field("online", &P::online, "how good the factory calibration is, and how fast it may change")};
  }
};

struct OutputConfig {
  pipeline::WorldFrame world_frame = pipeline::WorldFrame::kEnu;
  Mount mount;
  std::optional<double> initial_heading_rad;
  template <class P = OutputConfig>
  static constexpr auto fields() {
    return std::tuple{
        field("world_frame", &P::world_frame,
              "enu (body x forward, y left, z up) or ned (body x forward, y right, z down)"),
        field("mount", &P::mount,
              "body from sensor: \"+x +y +z\" (which sensor axis is body x, y, z), three rows, or [w, x, y, z]"),
        field("initial_heading_rad", &P::initial_heading_rad, in_range(-3.15, 3.15),
              "heading at the start, counter-clockwise from east, until a magnetometer says otherwise")};
  }
};

struct StateConfig {
  std::string directory;
  int keep = 3;
  double save_period_s = 60.0;
  template <class P = StateConfig>
  static constexpr auto fields() {
    return std::tuple{
        field("directory", &P::directory,
              "what was learnt is kept here (relative: to the working folder); empty: $STATE_DIRECTORY (systemd), else "
              "nowhere"),
        field("keep", &P::keep, in_range(1, 100), "so many good versions are kept"),
        field("save_period_s", &P::save_period_s, in_range(0.1, 86400), "a change is on disk after at most this time")};
  }
};

struct DaemonConfig {
  SourceConfig source;
  SensorConfig sensor;
  calib::RestDetectorParams rest;
  CalibrationConfig calibration;
  fusion::AttitudeFilterParams attitude;
  std::vector<sim::EffectConfig> compensate;  ///< all of a kind that CompensateStage knows
  OutputConfig output;
  DdsParams dds;
  StateConfig state;
  pipeline::ThreadParams threads;
  double stale_after_s = 1.0;
  template <class P = DaemonConfig>
  static constexpr auto fields() {
    return std::tuple{
        field("source", &P::source, "where the samples come from"),
        field("sensor", &P::sensor, "the sensor: identity, factory calibration, limits"),
        field("rest", &P::rest, "when the body is at rest"),
        field("calibration", &P::calibration, "learning from rest"),
        field("attitude", &P::attitude, "the attitude filter"),
        field("compensate", &P::compensate, "known physics to take out, a list of effects as in a simulation"),
        field("output", &P::output, "frames of what is published"),
        field("dds", &P::dds, "publishing"),
        field("state", &P::state, "keeping what was learnt"),
        field("threads", &P::threads, "cores, priorities, memory"),
        field("stale_after_s", &P::stale_after_s, in_range(0.01, 3600), "without a sample for so long: STALE")};
  }
};

/// Whether `compensate:` takes this entry: an effect that is a causal function of the readings, always in force
/// (docs/decisions/072-compensation.md).
[[nodiscard]] bool can_be_compensated(const sim::EffectConfig& effect);

/// Reads and checks a configuration. 66: no such file; 78: every fault as file:line:column.
[[nodiscard]] Result<DaemonConfig> read_config(const std::string& path);
[[nodiscard]] Result<DaemonConfig> parse_config(const std::string& text, const std::string& name);

/// Every value with its meaning, in a form that reads back from any folder; values that are the default are marked.
[[nodiscard]] std::string print_config(const DaemonConfig& config);

/// The parts as the pipeline takes them.
[[nodiscard]] pipeline::StagesParams stages_params(const DaemonConfig& config);
[[nodiscard]] CalibrationSnapshot factory_calibration(const SensorConfig& sensor);

// Types that only this file's structs use.
void read_value(const YAML::Node& node, pipeline::WorldFrame& out, const Range&, const std::string& key,
                YamlFaults& faults);
void read_value(const YAML::Node& node, std::optional<double>& out, const Range& range, const std::string& key,
                YamlFaults& faults);
void read_value(const YAML::Node& node, std::vector<sim::EffectConfig>& out, const Range&, const std::string& key,
                YamlFaults& faults);

}  // namespace stillpoint::io
