#include "exchange/import.h"

#include <fmt/format.h>

#include <algorithm>

#include "exchange/mcap.h"
#include "exchange/read_table.h"
#include "exchange/ulog.h"
#include "exchange/unpack.h"

namespace stillpoint::exchange {
namespace {

using Columns = std::vector<std::string>;

SensorColumns sensor(Quantity q, Columns columns, std::string unit, std::string table = "") {
  return {q, std::move(columns), std::move(unit), std::move(table)};
}

struct TablePreset {
  std::string_view name, about;
  ColumnMap map;
};

/// The programs whose tables are known. A preset serves where all the columns that it has for a table are in it.
const std::vector<TablePreset>& table_presets() {
  using enum Quantity;
  static const std::vector<TablePreset> kAll{
      {"euroc",
       "EuRoC and TUM VI: imu0/data.csv",
       {"#timestamp [ns]",
        "ns",
        {sensor(kAcc, {"a_RS_S_x [m s^-2]", "a_RS_S_y [m s^-2]", "a_RS_S_z [m s^-2]"}, "m/s^2"),
         sensor(kGyr, {"w_RS_S_x [rad s^-1]", "w_RS_S_y [rad s^-1]", "w_RS_S_z [rad s^-1]"}, "rad/s")}}},
      {"kalibr",
       "Kalibr's bag creater and extractor, imu_utils: imu0.csv",
       {"timestamp",
        "ns",
        {sensor(kAcc, {"alpha_x", "alpha_y", "alpha_z"}, "m/s^2"),
         sensor(kGyr, {"omega_x", "omega_y", "omega_z"}, "rad/s")}}},
      {"sensor_logger",
       "Sensor Logger (iOS, Android): the exported zip or its folder",
       {"time",
        "ns",
        {sensor(kAcc, {"x", "y", "z"}, "", "TotalAcceleration"), sensor(kGyr, {"x", "y", "z"}, "rad/s", "Gyroscope"),
         sensor(kMag, {"x", "y", "z"}, "uT", "Magnetometer")}}},
      {"phyphox",
       "phyphox (iOS, Android): the exported zip, its folder or one table",
       {"Time (s)",
        "s",
        {sensor(kAcc, {"X (m/s^2)", "Y (m/s^2)", "Z (m/s^2)"}, "", "Accelerometer"),
         sensor(kGyr, {"X (rad/s)", "Y (rad/s)", "Z (rad/s)"}, "rad/s", "Gyroscope"),
         sensor(kMag, {"X (\xC2\xB5T)", "Y (\xC2\xB5T)", "Z (\xC2\xB5T)"}, "uT", "Magnetometer")}}},
      {"androsensor",
       "AndroSensor (Android): its CSV",
       {"Time since start in ms",
        "ms",
        {sensor(kAcc,
                {"ACCELEROMETER X (m/s\xC2\xB2)", "ACCELEROMETER Y (m/s\xC2\xB2)", "ACCELEROMETER Z (m/s\xC2\xB2)"},
                "m/s^2"),
         sensor(kGyr, {"GYROSCOPE X (rad/s)", "GYROSCOPE Y (rad/s)", "GYROSCOPE Z (rad/s)"}, "rad/s"),
         sensor(kMag, {"MAGNETIC FIELD X (\xCE\xBCT)", "MAGNETIC FIELD Y (\xCE\xBCT)", "MAGNETIC FIELD Z (\xCE\xBCT)"},
                "uT")}}},
  };
  return kAll;
}

std::string leaf(const std::string& file) {
  const auto at = file.find_last_of("/\\:");
  return at == std::string::npos ? file : file.substr(at + 1);
}

/// What of the preset is in this table; without sensors: nothing. EuRoC's first name loses its comment sign.
ColumnMap part_of(const TablePreset& preset, const Table& table) {
  ColumnMap part = preset.map;
  if (part.time.front() == '#' && table.find(part.time) == nullptr) part.time.erase(0, 1);
  const bool timed = table.find(part.time) != nullptr;
  std::erase_if(part.sensors, [&](const SensorColumns& s) {
    const auto missing = [&](const std::string& c) { return table.find(c) == nullptr; };
    return !timed || leaf(table.name).rfind(s.table, 0) != 0 ||
           std::any_of(s.columns.begin(), s.columns.end(), missing);
  });
  return part;
}

/// One stream a quantity: of several the one whose table's name promises raw readings.
void keep_one_each(std::vector<Stream>& streams, std::vector<std::string>& reasons) {
  std::vector<Stream> kept;
  for (Stream& s : streams) {
    const auto same = std::find_if(kept.begin(), kept.end(), [&](const Stream& k) { return k.quantity == s.quantity; });
    if (same == kept.end())
      kept.push_back(std::move(s));
    else
      reasons.push_back(fmt::format("{} is left out: {} comes from {}", s.from, name(s.quantity), same->from));
  }
  streams = std::move(kept);
}

/// Sensor Logger's accelerometer has no gravity in it; where TotalAcceleration was not logged, it is the sum of the
/// two.
void sum_parts_of_force(std::vector<Table>& tables, std::vector<std::string>& reasons) {
  constexpr const char* kColumns[] = {"time", "x", "y", "z"};
  const auto table_of = [&](std::string_view sensor) {
    return std::find_if(tables.begin(), tables.end(), [&](const Table& t) {
      return leaf(t.name).rfind(sensor, 0) == 0 &&
             std::all_of(std::begin(kColumns), std::end(kColumns), [&](const char* c) { return t.find(c) != nullptr; });
    });
  };
  const auto force = table_of("Accelerometer."), gravity = table_of("Gravity.");
  if (table_of("TotalAcceleration") != tables.end() || force == tables.end() || gravity == tables.end()) return;
  const Column &t = *force->find("time"), &u = *gravity->find("time");
  if (t.origin != u.origin || t.values != u.values) {
    reasons.push_back(fmt::format("{}: no accelerometer: its gravity in {} has other times; log TotalAcceleration",
                                  force->name, leaf(gravity->name)));
    return;
  }
  for (Column& c : force->columns)
    if (c.name == "x" || c.name == "y" || c.name == "z")
      for (std::size_t i = 0; i < c.values.size(); ++i) c.values[i] += gravity->find(c.name)->values[i];
  const std::string parts = fmt::format("{} + {}", leaf(force->name), leaf(gravity->name));
  force->name.replace(force->name.size() - leaf(force->name).size(), std::string::npos, "TotalAcceleration = " + parts);
  reasons.push_back(fmt::format("{}: both have the same times", force->name));
  tables.erase(gravity);
}

/// The preset of a log; empty: a table, or nothing that is known.
std::string_view log_kind(const NamedText& file) {
  return is_ulog(file.text) ? "px4" : is_mcap(file.text) ? "ros2" : "";
}

std::string what_it_is(const NamedText& file) {
  for (const Preset& p : presets())
    if (p.name == log_kind(file)) return fmt::format("it is {} (--preset {})", p.about, p.name);
  const auto table = parse_table(file.text, file.name);
  if (!table) return "it is no table either: " + table.error().message;
  for (const TablePreset& p : table_presets())
    if (!part_of(p, *table).sensors.empty()) return fmt::format("it is of {} (--preset {})", p.about, p.name);
  std::vector<std::string> names;
  for (const Column& c : table->columns) names.push_back(c.name);
  return fmt::format("it is a table with the columns {}; import it without --preset", fmt::join(names, ", "));
}

Error other_kind(const NamedText& file, const std::string& preset) {
  return {ErrorKind::kBadData, fmt::format("{}: not what --preset {} reads; {}", file.name, preset, what_it_is(file))};
}

class Tables {
 public:
  Tables(const std::string& path, const ImportOptions& options) : path_(path), options_(options) {}

  Result<Imported> read(const std::vector<NamedText>& files) {
    std::vector<Table> tables;
    for (const NamedText& file : files) {
      auto table = parse_table(file.text, file.name);
      if (table)
        tables.push_back(std::move(*table));
      else
        note(table.error());
    }
    if (!options_.map && (options_.preset.empty() || options_.preset == "sensor_logger"))
      sum_parts_of_force(tables, reasons_);
    for (const Table& table : tables) read_one(table);
    if (streams_.empty() && first_fault_) return tl::unexpected(*first_fault_);
    if (streams_.empty() && !options_.preset.empty()) return tl::unexpected(other_kind(files.front(), options_.preset));
    keep_one_each(streams_, reasons_);
    auto imported = merge(std::move(streams_), path_);
    if (imported) imported->reasons.insert(imported->reasons.begin(), reasons_.begin(), reasons_.end());
    return imported;
  }

 private:
  /// In an archive a table that cannot be read, a log of GPS or a note, does no harm.
  void read_one(const Table& table) {
    const ColumnMap map = map_for(table);
    if (map.sensors.empty() && !options_.preset.empty()) return;
    const auto streams = read_streams(table, map, reasons_);
    if (!streams) return note(streams.error());
    streams_.insert(streams_.end(), streams->begin(), streams->end());
    name_columns_left(table, map);
  }

  /// A sensor that is not recognised by its names must not be missed in silence. A second time is none.
  void name_columns_left(const Table& table, const ColumnMap& map) {
    const std::string time = map.time.empty() ? time_column(table) : map.time;
    std::vector<std::string> left;
    for (const Column& c : table.columns) {
      const bool taken = std::any_of(map.sensors.begin(), map.sensors.end(), [&](const SensorColumns& s) {
        return table.name.find(s.table) != std::string::npos &&
               std::find(s.columns.begin(), s.columns.end(), c.name) != s.columns.end();
      });
      if (!taken && c.name != time && rank_as_time(c.name) == 0 && c.numbers > 0) left.push_back(c.name);
    }
    if (!left.empty()) reasons_.push_back(fmt::format("{}: not taken: {}", table.name, fmt::join(left, ", ")));
  }

  void note(const Error& error) {
    if (!first_fault_) first_fault_ = error;
    reasons_.push_back("not used: " + error.message);
  }

  ColumnMap map_for(const Table& table) {
    if (options_.map) return *options_.map;
    for (const TablePreset& preset : table_presets()) {
      if (!options_.preset.empty() && preset.name != options_.preset) continue;
      ColumnMap part = part_of(preset, table);
      if (part.sensors.empty() && options_.preset.empty()) continue;
      if (!part.sensors.empty()) reasons_.push_back(fmt::format("{}: the columns of {}", table.name, preset.about));
      return part;
    }
    return guess(table);
  }

  const std::string& path_;
  const ImportOptions& options_;
  std::vector<Stream> streams_;
  std::vector<std::string> reasons_;
  std::optional<Error> first_fault_;
};

}  // namespace

const std::vector<Preset>& presets() {
  static const std::vector<Preset> kAll = [] {
    std::vector<Preset> all;
    for (const TablePreset& p : table_presets()) all.push_back({p.name, p.about});
    all.push_back({"px4", "PX4's flight log (.ulg)"});
    all.push_back({"ros2", "ROS 2 bag in MCAP: sensor_msgs Imu, MagneticField, Temperature"});
    return all;
  }();
  return kAll;
}

Result<Imported> import_recording(const std::string& path, const ImportOptions& options) {
  const auto files = read_unpacked(path);
  if (!files) return tl::unexpected(files.error());
  if (files->empty()) return fail(ErrorKind::kNoInput, path + ": no file in it");
  if (files->front().text.rfind("SQLite format 3", 0) == 0)
    return fail(ErrorKind::kBadData,
                path + ": a ROS 2 bag in SQLite; convert it with `ros2 bag convert` to storage_id mcap");
  if (files->front().text.rfind("#ROSBAG V2", 0) == 0)
    return fail(ErrorKind::kBadData, path + ": a ROS 1 bag; convert it with `rosbags-convert` to a ROS 2 bag in MCAP");
  const std::string& preset = options.preset;
  const std::string_view wanted = preset == "px4" || preset == "ros2" ? std::string_view(preset) : "";
  const auto fits = [&](const NamedText& file) { return preset.empty() || log_kind(file) == wanted; };
  if (std::none_of(files->begin(), files->end(), fits)) return tl::unexpected(other_kind(files->front(), preset));
  for (const NamedText& file : *files) {
    if (options.map || log_kind(file).empty() || !fits(file)) continue;
    std::vector<std::string> reasons;
    auto streams = is_ulog(file.text) ? read_ulog(file.text, file.name, reasons)
                                      : read_mcap(file.text, file.name, options.topic, reasons);
    if (!streams) return tl::unexpected(streams.error());
    auto imported = merge(std::move(*streams), file.name);
    if (imported) imported->reasons.insert(imported->reasons.begin(), reasons.begin(), reasons.end());
    return imported;
  }
  return Tables(path, options).read(*files);
}

}  // namespace stillpoint::exchange
