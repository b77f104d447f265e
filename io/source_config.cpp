#include "io/source_config.h"

#include <charconv>
#include <filesystem>
#include <map>

#include "io/recording_columns.h"

namespace stillpoint::io {

const Words<SourceKind> kSourceKinds{{"recording", SourceKind::kRecording},
                                     {"simulation", SourceKind::kSimulation},
                                     {"stream", SourceKind::kStream},
                                     {"ros2", SourceKind::kRos2},
                                     {"iio", SourceKind::kIio}};
const Words<SourceEnd> kSourceEnds{{"stop", SourceEnd::kStop}, {"wait", SourceEnd::kWait}};
const Words<StreamFormat> kStreamFormats{
    {"auto", StreamFormat::kAuto}, {"text", StreamFormat::kText}, {"frames", StreamFormat::kFrames}};

namespace {

/// Columns in counts, and the key that says what a count is.
struct CountsKey {
  ColumnGroup group;
  double StreamParams::*scale;
  const char* key;
};
constexpr CountsKey kCountsKeys[] = {{kAccGroup, &StreamParams::acc_mps2_per_count, "acc_mps2_per_count"},
                                     {kGyrGroup, &StreamParams::gyr_radps_per_count, "gyr_radps_per_count"},
                                     {kMagGroup, &StreamParams::mag_uT_per_count, "mag_uT_per_count"}};

void check_column(const YAML::Node& where, const std::string& name, const StreamParams& stream, YamlFaults& faults) {
  const auto known = known_column(name);
  if (!known || known->group > kTempGroup) {
    const std::string mistake = likely_mistake(name);
    return faults.add(where, fmt::format("{} is no reading; known are time_s/ms/us/ns, acc_x_mps2/g/counts, "
                                         "gyr_x_radps/dps/counts, mag_x_uT/gauss/T/counts, temp_degC{}",
                                         quote(name), mistake.empty() ? "" : "; " + mistake));
  }
  if (known->unit != "counts") return;
  for (const auto& c : kCountsKeys)
    if (c.group == known->group && stream.*c.scale == 0.0)
      faults.add(where, fmt::format("'{}' needs '{}': what one count is", name, c.key));
}

/// Then it is meant for a position.
bool is_number(const std::string& theirs) {
  double value = 0.0;
  const char* end = theirs.data() + theirs.size();
  const auto [stop, code] = std::from_chars(theirs.data(), end, value);
  return code != std::errc::invalid_argument && stop == end;
}

/// Where each is taken from: one place for each, all by name or all by position.
void check_places(const ColumnMap& columns, const YAML::Node& node, YamlFaults& faults) {
  std::map<std::string, std::string> by_theirs;
  std::map<std::size_t, std::string> by_field;
  std::size_t positions = 0;
  for (const auto& [ours, theirs] : columns) {
    const YAML::Node where = node.IsMap() ? node[ours] : node;
    positions += is_number(theirs) ? 1 : 0;
    if (is_number(theirs) && !column_position(theirs))
      faults.add(where, fmt::format("'{}' is at position {}; positions are whole numbers from 1 to {}", ours, theirs,
                                    kMostColumns));
    if (const auto [other, first] = by_theirs.emplace(theirs, ours); !first)
      faults.add(where, fmt::format("'{}' and '{}' are both taken from {}", other->second, ours, quote(theirs)));
    const auto known = known_column(ours);
    if (!known) continue;
    if (const auto [other, first] = by_field.emplace(known->field, ours); !first)
      faults.add(where, fmt::format("'{}' and '{}' are the same reading; name it once", other->second, ours));
  }
  if (positions > 0 && positions < columns.size())
    faults.add(node, "names and positions are mixed; give the name of each, or the position of each");
}

void check_stream(const StreamParams& stream, const YAML::Node& node, YamlFaults& faults) {
  if (!node["from"])
    faults.add(node, "'from' is missing here: stdin, a path such as /dev/ttyUSB0, or an address such as udp://:5555");
  else if (stream.from.empty())
    faults.add(node["from"], "'from' is empty");
  for (const auto& [ours, theirs] : stream.columns) check_column(node["columns"], ours, stream, faults);
  if (node["columns"]) check_places(stream.columns, node["columns"], faults);
}

void check_ros2(const Ros2Params& ros2, const YAML::Node& node, YamlFaults& faults) {
  if (ros2.imu_topic.empty() && ros2.mag_topic.empty())
    faults.add(node, "neither 'imu_topic' nor 'mag_topic' names a topic");
}

}  // namespace

std::optional<std::size_t> column_position(const std::string& theirs) {
  std::size_t value = 0;
  const char* end = theirs.data() + theirs.size();
  const auto [stop, code] = std::from_chars(theirs.data(), end, value);
  const bool is_one = code == std::errc{} && stop == end && value >= 1 && value <= kMostColumns;
  return is_one ? std::optional(value) : std::nullopt;
}

bool is_path(const std::string& from) {
  return !from.empty() && from != "stdin" && from.find("://") == std::string::npos;
}

std::string SourceConfig::description() const {
  switch (kind) {
    case SourceKind::kNone:
      return "none";
    case SourceKind::kStream:
      return stream.from;
    case SourceKind::kRos2:
      return fmt::format("ROS 2 {} {}", ros2.imu_topic, ros2.mag_topic);
    case SourceKind::kIio:
      return fmt::format("IIO {}", iio.uri);
    default:
      return fmt::format("{} at {}", file, speed > 0 ? fmt::format("{}x", speed) : "full speed");
  }
}

void finish_source(SourceConfig& source, const YAML::Node& root, const std::string& name, YamlFaults& faults) {
  const YAML::Node node = root["source"];
  source.place = name;
  if (!node || !node.IsMap()) return;
  if (node["mount"] && node.size() == 1) return;  // all that reading a recording asks; the daemon asks for a source
  if (!node["kind"]) faults.add(node, "'kind' is missing here: recording, simulation, stream, ros2 or iio");
  if (source.kind == SourceKind::kStream) check_stream(source.stream, node, faults);
  if (source.kind == SourceKind::kRos2) check_ros2(source.ros2, node, faults);
  const YAML::Node named = node["file"] ? node["file"] : node["from"] ? node["from"] : node["uri"];
  const YAML::Mark mark = (named ? named : node).Mark();
  source.place = fmt::format("{}:{}:{}", name, mark.line + 1, mark.column + 1);
  if (source.kind == SourceKind::kRecording || source.kind == SourceKind::kSimulation) {
    if (!node["file"])
      faults.add(node, "'file' is missing here: the recording (.csv) or the simulation (.yaml) to take samples from");
    else if (source.file.empty())
      faults.add(node["file"], "'file' is empty");
  }
  for (std::string* path : {&source.file, &source.stream.from})
    if (is_path(*path) && std::filesystem::path(*path).is_relative())
      *path = (std::filesystem::path(name).parent_path() / *path).lexically_normal().string();
}

void read_value(const YAML::Node& node, SourceConfig& out, const Range&, const std::string&, YamlFaults& faults) {
  if (!node.IsMap()) return faults.add(node, "expected keys with values here");
  std::vector<std::string> known;
  for_each_block(out, [&](auto& params, const auto& fields) {
    append_names(fields, known);
    read_known_fields(node, params, fields, faults);
  });
  if (out.kind == SourceKind::kNone) {  // of which kind it is meant to be nobody knows
    append_names(StreamParams::fields(), known);
    append_names(Ros2Params::fields(), known);
    append_names(IioParams::fields(), known);
    append_names(SourceConfig::live_fields(), known);
  }
  refuse_unknown_keys(node, known, faults);
}

void read_value(const YAML::Node& node, SourceKind& out, const Range&, const std::string& key, YamlFaults& faults) {
  read_word(node, out, kSourceKinds, key, faults);
}
void read_value(const YAML::Node& node, SourceEnd& out, const Range&, const std::string& key, YamlFaults& faults) {
  read_word(node, out, kSourceEnds, key, faults);
}
void read_value(const YAML::Node& node, StreamFormat& out, const Range&, const std::string& key, YamlFaults& faults) {
  read_word(node, out, kStreamFormats, key, faults);
}

void read_value(const YAML::Node& node, ColumnMap& out, const Range&, const std::string& key, YamlFaults& faults) {
  ColumnMap columns;
  if (node.IsMap()) {
    for (const auto& entry : node) {
      if (!entry.second.IsScalar())
        return faults.add(entry.second, fmt::format("'{}' must be a name or a position", entry.first.Scalar()));
      columns.emplace_back(entry.first.Scalar(), entry.second.Scalar());
    }
  } else if (node.IsSequence()) {
    for (std::size_t i = 0; i < node.size(); ++i)
      if (const std::string name = node[i].IsScalar() ? node[i].Scalar() : ""; name != "-")
        columns.emplace_back(name, std::to_string(i + 1));
  } else {
    return faults.add(node, fmt::format("'{}' must be a list of what the columns hold, or a map of such names", key));
  }
  out = std::move(columns);
}

void read_value(const YAML::Node& node, std::vector<std::string>& out, const Range&, const std::string& key,
                YamlFaults& faults) {
  std::vector<std::string> names;
  if (node.IsScalar()) names.push_back(node.Scalar());
  if (node.IsSequence())
    for (const auto& item : node) names.push_back(item.IsScalar() ? item.Scalar() : "");
  if (names.empty() && !node.IsSequence()) return faults.add(node, fmt::format("'{}' must be a list of names", key));
  out = std::move(names);
}

void read_value(const YAML::Node& node, Mount& out, const Range&, const std::string& key, YamlFaults& faults) {
  std::variant<Mount, std::string> mount;
  if (node.IsScalar()) {
    mount = mount_of_names(node.Scalar());
  } else {
    Mat3 R = Mat3::Identity();
    if (node.IsSequence() && node.size() == 4) {
      std::vector<double> q;
      if (!reads(node, q, finite(), key, faults)) return;
      if (q.size() == 4) R = Quat(q[0], q[1], q[2], q[3]).toRotationMatrix();
    } else if (!reads(node, R, finite(), key, faults)) {
      return;
    }
    mount = mount_of_matrix(R);
  }
  if (const auto* fault = std::get_if<std::string>(&mount))
    return faults.add(node, fmt::format("'{}' {}", key, *fault));
  out = std::get<Mount>(mount);
}

}  // namespace stillpoint::io
