#include "io/recording_columns.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <vector>

#include "core/nearest.h"
#include "core/units.h"

namespace stillpoint::io {
namespace {

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
    {kAccGroup, "acc_", kAxes, "g", kStandardGravity_mps2},
    {kAccGroup, "acc_", kAxes, "counts", 1.0},
    {kGyrGroup, "gyr_", kAxes, "radps", 1.0},
    {kGyrGroup, "gyr_", kAxes, "dps", kRadPerDeg},
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

std::string lower(std::string_view text) {
  std::string out(text);
  std::transform(out.begin(), out.end(), out.begin(), [](unsigned char c) { return std::tolower(c); });
  return out;
}

std::string mistake_of_name(std::string_view name) {
  for (const Family& family : kFamilies) {
    for (std::size_t part = 0; part < kColumnGroupInfo[family.group].size; ++part) {
      const std::string stem = fmt::format("{}{}", family.stem, family.parts[part]),
                        known = stem + std::string(family.unit);
      if (name != known && lower(name) == lower(known))
        return fmt::format("column '{}' has to be written '{}'", name, known);
      if (!family.unit.empty() && name == stem.substr(0, stem.size() - 1))
        return fmt::format("column '{}' lacks its unit, as in '{}'", name, known);
    }
  }
  return {};
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

std::string meant_column(std::string_view name) {
  std::vector<std::string> known;
  for (const Family& family : kFamilies)
    for (std::size_t part = 0; part < kColumnGroupInfo[family.group].size; ++part)
      known.push_back(fmt::format("{}{}{}", family.stem, family.parts[part], family.unit));
  return std::string(nearest(name, known));
}

std::string likely_mistake(std::string_view line) {
  const auto has = [line](char c) { return line.find(c) != std::string_view::npos; };
  if (has('\0')) return "this is no UTF-8 text: a binary file, or UTF-16; save it as CSV in UTF-8";
  if (has('\r')) return "lines end with a carriage return alone; end them with a line feed";
  if (has('"')) return "the names stand in quotes; write names and numbers without them";
  if (has(';')) return "separated by semicolons; expected are commas, and points in the numbers";
  if (has('\t')) return "separated by tabs; expected are commas";
  const std::string_view first = line.substr(0, line.find(','));
  if (!first.empty() && first.find_first_not_of("0123456789.+-eE ") == std::string_view::npos)
    return "the first line holds numbers; expected is a line of column names before them";
  for (std::size_t start = 0, end = 0; start < line.size(); start = end + 1) {
    end = std::min(line.find(',', start), line.size());
    if (std::string mistake = mistake_of_name(line.substr(start, end - start)); !mistake.empty()) return mistake;
  }
  return {};
}

}  // namespace stillpoint::io
