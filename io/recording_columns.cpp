#include "io/recording_columns.h"

#include <algorithm>

namespace stillpoint::io {
namespace {

constexpr double kG = 9.80665;
constexpr double kDeg = 0.017453292519943295;

/// `part` is what stands between the group's stem and its unit, or the whole name where there is no unit.
struct Family {
  ColumnGroup group;
  std::string_view stem;
  std::array<std::string_view, 4> parts;
  std::string_view unit;
  double to_si;
};

constexpr std::array<std::string_view, 4> kAxes{"x_", "y_", "z_"};
constexpr std::array<Family, 20> kFamilies{{
    {kTimeGroup, "time_", {""}, "s", 1e9},
    {kTimeGroup, "time_", {""}, "ms", 1e6},
    {kTimeGroup, "time_", {""}, "us", 1e3},
    {kTimeGroup, "time_", {""}, "ns", 1.0},
    {kAccGroup, "acc_", kAxes, "mps2", 1.0},
    {kAccGroup, "acc_", kAxes, "g", kG},
    {kAccGroup, "acc_", kAxes, "counts", 1.0},
    {kGyrGroup, "gyr_", kAxes, "radps", 1.0},
    {kGyrGroup, "gyr_", kAxes, "dps", kDeg},
    {kGyrGroup, "gyr_", kAxes, "counts", 1.0},
    {kMagGroup, "mag_", kAxes, "uT", 1.0},
    {kMagGroup, "mag_", kAxes, "gauss", 100.0},
    {kMagGroup, "mag_", kAxes, "T", 1e6},
    {kMagGroup, "mag_", kAxes, "counts", 1.0},
    {kTempGroup, "temp_", {""}, "degC", 1.0},
    {kCurrentGroup, "current_", {""}, "A", 1.0},
    {kSupplyGroup, "supply_", {""}, "V", 1.0},
    {kRefAttitudeGroup, "ref_", {"qw", "qx", "qy", "qz"}, "", 1.0},
    {kRefPositionGroup, "ref_", {"px_", "py_", "pz_"}, "m", 1.0},
    {kRefMovingGroup, "ref_", {"moving"}, "", 1.0},
}};

/// Takes `head` off `name` when it begins with it.
bool take(std::string_view& name, std::string_view head) {
  if (name.substr(0, head.size()) != head) return false;
  name.remove_prefix(head.size());
  return true;
}

}  // namespace

std::optional<KnownColumn> known_column(std::string_view name) {
  for (const Family& family : kFamilies) {
    const ColumnGroupInfo& group = kColumnGroupInfo[family.group];
    for (std::size_t part = 0; part < group.size; ++part) {
      std::string_view rest = name;
      if (take(rest, family.stem) && take(rest, family.parts[part]) && rest == family.unit)
        return KnownColumn{family.group, group.first + part, family.to_si, family.unit};
    }
  }
  return std::nullopt;
}

}  // namespace stillpoint::io
