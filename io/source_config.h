/// The `source:` block of the daemon's configuration: where readings come from (docs/sources.md).
#pragma once
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/fields.h"
#include "io/mount.h"
#include "io/yaml_words.h"
#include "pipeline/fault_injector.h"

namespace stillpoint::io {

enum class SourceKind { kNone, kRecording, kSimulation, kStream, kRos2, kIio };
enum class SourceEnd { kStop, kWait };
enum class StreamFormat { kAuto, kText, kFrames };

/// A line has no more.
inline constexpr std::size_t kMostColumns = 64;

/// Our column name with its unit, and where it is found: a name of the stream, or a position counted from 1.
using ColumnMap = std::vector<std::pair<std::string, std::string>>;
/// The position that such a text is, from 1 to kMostColumns; nothing: a name, or no position that there can be.
[[nodiscard]] std::optional<std::size_t> column_position(const std::string& theirs);

struct StreamParams {
  std::string from;
  StreamFormat format = StreamFormat::kAuto;
  int baud = 115200;
  ColumnMap columns;
  double acc_mps2_per_count = 0.0, gyr_radps_per_count = 0.0, mag_uT_per_count = 0.0;
  double rate_hz = 0.0;
  template <class P = StreamParams>
  static constexpr auto fields() {
    return std::tuple{
        field("from", &P::from,
              "stdin, a serial line, FIFO or file by its path, tcp://HOST:PORT, tcp-listen://:PORT or udp://:PORT"),
        field("format", &P::format, "auto, text (lines of CSV or JSON) or frames (docs/sources.md)"),
        field("baud", &P::baud, in_range(300, 4e6), "of a serial line; 8 data bits, no parity, 1 stop bit"),
        field("columns", &P::columns,
              "{acc_x_g: NAME, ...}, {acc_x_g: POSITION from 1, ...}, or the list [time_ms, acc_x_g, -, ...]"),
        field("acc_mps2_per_count", &P::acc_mps2_per_count, in_range(0, 1e3), "scale of acc_x_counts and its axes"),
        field("gyr_radps_per_count", &P::gyr_radps_per_count, in_range(0, 1e3), "scale of gyr_x_counts and its axes"),
        field("mag_uT_per_count", &P::mag_uT_per_count, in_range(0, 1e3), "scale of mag_x_counts and its axes"),
        field("rate_hz", &P::rate_hz, in_range(0, 1e5),
              "of a stream without time stamps; 0: learnt from its first second")};
  }
};

struct Ros2Params {
  std::string imu_topic = "imu/data_raw";
  std::string mag_topic = "imu/mag";
  int domain = -1;
  bool reliable = false;
  bool use_covariance = true;
  template <class P = Ros2Params>
  static constexpr auto fields() {
    return std::tuple{
        field("imu_topic", &P::imu_topic, "sensor_msgs/Imu, as `ros2 topic list` names it; empty: none"),
        field("mag_topic", &P::mag_topic, "sensor_msgs/MagneticField; empty: none"),
        field("domain", &P::domain, in_range(-1, 232), "ROS_DOMAIN_ID of the driver; -1: that of 'dds'"),
        field("reliable", &P::reliable, "true: ask for what was lost again; a best-effort driver is then not heard"),
        field("use_covariance", &P::use_covariance,
              "true: a covariance that begins with -1 says that the sensor is not there (REP-145), a positive one how "
              "noisy it is at least")};
  }
};

struct IioParams {
  std::string uri = "local:";
  std::vector<std::string> devices;
  double rate_hz = 0.0;
  double poll_hz = 100.0;
  double block_s = 0.005;
  std::string trigger;
  template <class P = IioParams>
  static constexpr auto fields() {
    return std::tuple{
        field("uri", &P::uri, "local: or ip:HOST[:PORT] of an iiod"),
        field("devices", &P::devices, "names as `stillpoint devices` lists them; empty: all with a motion sensor"),
        field("rate_hz", &P::rate_hz, in_range(0, 1e5), "sampling frequency to set; 0: as it is"),
        field("poll_hz", &P::poll_hz, in_range(0.1, 1e4), "how often a device without a buffer is read"),
        field("block_s", &P::block_s, in_range(1e-4, 1.0), "so long a buffer may collect before it is handed on"),
        field("trigger", &P::trigger, "name of the trigger to set; empty: as it is")};
  }
};

/// Where each sensor sits in the common sensor frame, applied as readings come in.
struct SensorMounts {
  Mount accelerometer, gyroscope, magnetometer;
  template <class P = SensorMounts>
  static constexpr auto fields() {
    return std::tuple{field("accelerometer", &P::accelerometer, "\"+x -z +y\", three rows, or [w, x, y, z]"),
                      field("gyroscope", &P::gyroscope, "the same for the gyroscope"),
                      field("magnetometer", &P::magnetometer, "the same for the magnetometer")};
  }
};

/// `fields()` are the keys of every kind; each kind adds its own, on the same level.
struct SourceConfig {
  SourceKind kind = SourceKind::kNone;
  SourceEnd at_end = SourceEnd::kStop;
  std::optional<SensorMounts> mount;
  std::optional<pipeline::FaultParams> faults;
  std::string file;  ///< of a recording or a simulation, relative to the configuration's folder
  double speed = 1.0;
  int seed = 1;
  bool wait_for_file = false;
  double reopen_at_most_s = 5.0;
  StreamParams stream;
  Ros2Params ros2;
  IioParams iio;
  std::string place;  ///< "FILE:LINE:COLUMN" of what names the source, for messages about it

  template <class P = SourceConfig>
  static constexpr auto fields() {
    return std::tuple{
        field("kind", &P::kind, "recording, simulation, stream, ros2 or iio"),
        field("at_end", &P::at_end, "stop: the daemon ends with the source; wait: it stays and reports STALE"),
        field("mount", &P::mount, "how each sensor sits in the common sensor frame"),
        field("faults", &P::faults, "faults put in on purpose, to try out what a subscriber sees")};
  }
  template <class P = SourceConfig>
  static constexpr auto replay_fields() {
    return std::tuple{field("file", &P::file, "the recording (.csv) or the simulation (.yaml), relative to this file"),
                      field("speed", &P::speed, in_range(0.0, 1e6), "times real time; 0: as fast as possible"),
                      field("seed", &P::seed, in_range(0, 2e9), "of the simulation's noise"),
                      field("wait_for_file", &P::wait_for_file,
                            "true: a missing file is waited for; false: the daemon stops with 66")};
  }
  template <class P = SourceConfig>
  static constexpr auto live_fields() {
    return std::tuple{field("reopen_at_most_s", &P::reopen_at_most_s, in_range(0.1, 3600),
                            "a device that is gone is tried again after 0.1 s, then ever later, up to this")};
  }

  /// A sensor that goes on whether it is listened to or not: nothing may wait for an answer.
  [[nodiscard]] bool live() const {
    return kind == SourceKind::kStream || kind == SourceKind::kRos2 || kind == SourceKind::kIio;
  }
  /// For a log line.
  [[nodiscard]] std::string description() const;
};

extern const Words<SourceKind> kSourceKinds;
extern const Words<SourceEnd> kSourceEnds;
extern const Words<StreamFormat> kStreamFormats;

/// Calls `with(params, fields)` for each list of keys that this kind has.
template <class Config, class With>
void for_each_block(Config& source, const With& with) {
  with(source, SourceConfig::fields());
  if (!source.live()) return with(source, SourceConfig::replay_fields());
  if (source.kind == SourceKind::kStream) with(source.stream, StreamParams::fields());
  if (source.kind == SourceKind::kRos2) with(source.ros2, Ros2Params::fields());
  if (source.kind == SourceKind::kIio) with(source.iio, IioParams::fields());
  with(source, SourceConfig::live_fields());
}

/// Whether it names a file, a FIFO or a device: not empty, not stdin, no address.
[[nodiscard]] bool is_path(const std::string& from);

/// Rules between keys, and paths relative to the folder of the configuration `name`.
void finish_source(SourceConfig& source, const YAML::Node& root, const std::string& name, YamlFaults& faults);

void read_value(const YAML::Node& node, SourceConfig& out, const Range&, const std::string& key, YamlFaults& faults);
void read_value(const YAML::Node& node, SourceKind& out, const Range&, const std::string& key, YamlFaults& faults);
void read_value(const YAML::Node& node, SourceEnd& out, const Range&, const std::string& key, YamlFaults& faults);
void read_value(const YAML::Node& node, StreamFormat& out, const Range&, const std::string& key, YamlFaults& faults);
void read_value(const YAML::Node& node, ColumnMap& out, const Range&, const std::string& key, YamlFaults& faults);
void read_value(const YAML::Node& node, std::vector<std::string>& out, const Range&, const std::string& key,
                YamlFaults& faults);
void read_value(const YAML::Node& node, Mount& out, const Range&, const std::string& key, YamlFaults& faults);

}  // namespace stillpoint::io
