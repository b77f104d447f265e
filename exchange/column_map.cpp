#include "exchange/column_map.h"

#include "io/quote.h"
#include "io/yaml.h"

namespace stillpoint::exchange {
namespace {

std::string text_of(const YAML::Node& node, const std::string& key, io::YamlFaults& faults) {
  if (!node) return "";
  if (node.IsScalar()) return node.Scalar();
  faults.add(node, fmt::format("'{}' must be a text", key));
  return "";
}

void read_sensor(const YAML::Node& node, Quantity quantity, ColumnMap& map, io::YamlFaults& faults) {
  if (!node) return;
  if (!node.IsMap()) return faults.add(node, "expected {columns: [...], unit: ...} here");
  io::refuse_unknown_keys(node, {"columns", "column", "unit", "file"}, faults);
  SensorColumns s{quantity, {}, text_of(node["unit"], "unit", faults), text_of(node["file"], "file", faults)};
  const std::size_t wanted = quantity == Quantity::kTemp ? 1 : 3;
  if (const YAML::Node one = node["column"]; one && one.IsScalar()) s.columns.push_back(one.Scalar());
  if (const YAML::Node list = node["columns"]; list && list.IsSequence())
    for (const auto& item : list) s.columns.push_back(item.Scalar());
  if (s.columns.size() != wanted)
    return faults.add(node, wanted == 1 ? "one column is wanted: {column: T}" : "three columns are wanted: x, y and z");
  if (!s.unit.empty() && factor_of(quantity, s.unit) == 0.0)
    return faults.add(node["unit"], fmt::format("{} is no unit of {}; known are m/s^2, g, mg; rad/s, deg/s, mdps; uT, "
                                                "gauss, mgauss, nT, T; degC",
                                                io::quote(s.unit), name(quantity)));
  map.sensors.push_back(std::move(s));
}

/// "+x -y -z": which axis of the file is our x, y and z.
void read_mount(const YAML::Node& node, ColumnMap& map, io::YamlFaults& faults) {
  if (!node) return;
  std::istringstream words(text_of(node, "mount", faults));
  std::string word;
  Mat3 R = Mat3::Zero();
  int rows = 0;
  for (; words >> word; ++rows) {
    const bool good =
        rows < 3 && word.size() == 2 && (word[0] == '+' || word[0] == '-') && word[1] >= 'x' && word[1] <= 'z';
    if (!good) return faults.add(node, "'mount' must be three of +x -x +y -y +z -z, such as \"+x -y -z\"");
    R(rows, word[1] - 'x') = word[0] == '+' ? 1.0 : -1.0;
  }
  if (rows != 3 || std::abs(R.determinant() - 1.0) > 1e-9)
    return faults.add(node, "'mount' is no rotation: each axis once, and right-handed");
  map.R_body_sensor = R;
}

}  // namespace

Result<ColumnMap> read_column_map(const std::string& path) {
  const auto root = io::load_yaml(path);
  if (!root) return tl::unexpected(root.error());
  io::YamlFaults faults(path);
  ColumnMap map;
  io::refuse_unknown_keys(*root, {"time", "acc", "gyr", "mag", "temp", "mount"}, faults);
  if (const YAML::Node time = (*root)["time"]; time && time.IsScalar()) {
    map.time = time.Scalar();
  } else if (time && time.IsMap()) {
    io::refuse_unknown_keys(time, {"column", "unit"}, faults);
    map.time = text_of(time["column"], "column", faults);
    map.time_unit = text_of(time["unit"], "unit", faults);
    if (!map.time_unit.empty() && time_factor_ns(map.time_unit) == 0.0)
      faults.add(time["unit"], fmt::format("{} is no unit of time; s, ms, us and ns are", io::quote(map.time_unit)));
  }
  for (const Quantity quantity : {Quantity::kAcc, Quantity::kGyr, Quantity::kMag, Quantity::kTemp})
    read_sensor((*root)[name(quantity)], quantity, map, faults);
  read_mount((*root)["mount"], map, faults);
  if (faults.empty() && map.sensors.empty()) faults.add(*root, "no sensor; add acc: {columns: [x, y, z], unit: g}");
  if (!faults.empty()) return faults.error();
  return map;
}

}  // namespace stillpoint::exchange
