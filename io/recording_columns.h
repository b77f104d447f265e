/// The columns that a recording's CSV may have (docs/formats.md): their names, units and places in a row.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace stillpoint::io {

/// What belongs together: a triad, a quaternion, a position or a single column. All of its columns stand in a file, or
/// none.
enum ColumnGroup : std::size_t {
  kTimeGroup,
  kAccGroup,
  kGyrGroup,
  kMagGroup,
  kTempGroup,
  kCurrentGroup,
  kSupplyGroup,
  kRefAttitudeGroup,
  kRefPositionGroup,
  kRefMovingGroup,
  kColumnGroups
};

struct ColumnGroupInfo {
  const char* names;  // of its columns, as a message shows them
  std::size_t size;   // columns
  std::size_t first;  // where its numbers begin in a row
};

inline constexpr std::array<ColumnGroupInfo, kColumnGroups> kColumnGroupInfo{{
    {"time_s", 1, 0},
    {"acc_x/y/z_mps2", 3, 1},
    {"gyr_x/y/z_radps", 3, 4},
    {"mag_x/y/z_uT", 3, 7},
    {"temp_degC", 1, 10},
    {"current_A", 1, 11},
    {"supply_V", 1, 12},
    {"ref_qw/qx/qy/qz", 4, 13},
    {"ref_px/py/pz_m", 3, 17},
    {"ref_moving", 1, 20},
}};
inline constexpr std::size_t kRowFields = 21;

/// One row in SI units (uT for the field, degC for the temperature); time in ns. A field that is missing is NaN.
using RecordingRow = std::array<double, kRowFields>;

struct KnownColumn {
  ColumnGroup group;
  std::size_t field;      // in a RecordingRow
  double to_si;           // factor
  std::string_view unit;  // the name's last part
};

/// What a column name of the header means; nothing for a name that is not known.
std::optional<KnownColumn> known_column(std::string_view name);

/// The column that a name which is not known was meant to be; empty where none is near.
std::string meant_column(std::string_view name);

/// Why a line without known columns may be none: other separators, quotes, other line ends, capitals, missing units, or
/// no text at all. Empty when nothing of the kind shows.
std::string likely_mistake(std::string_view header_line);

}  // namespace stillpoint::io
