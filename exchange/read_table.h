/// From the columns of foreign tables to streams in SI units: units that nobody states are told from the values.
#pragma once
#include <string>
#include <vector>

#include "exchange/column_map.h"
#include "exchange/stream.h"
#include "exchange/table.h"

namespace stillpoint::exchange {

/// The sensors of this map that are in this table. What was told from values is added to `reasons`. Fails (65) with the
/// column and what to write into a map.
[[nodiscard]] Result<std::vector<Stream>> read_streams(const Table& table, const ColumnMap& map,
                                                       std::vector<std::string>& reasons);

/// How gravity turns in the accelerometer's frame against what the gyroscope says.
struct GravityTurn {
  double factor = 0.0;     ///< 1 for rad/s, 0.0175 for deg/s, negative where axes or signs disagree; 0: cannot be told
  bool same_axes = false;  ///< no other order or signs of the gyroscope's axes agree clearly better
};
[[nodiscard]] GravityTurn turn_of_gravity(const Stream& acc, const Stream& gyr);

}  // namespace stillpoint::exchange
