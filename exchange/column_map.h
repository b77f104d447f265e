/// Which columns of a foreign table are which sensor, in which unit: written down by a person (--map), known of a
/// program (--preset), or guessed from the names.
#pragma once
#include <array>
#include <string>
#include <vector>

#include "exchange/stream.h"
#include "exchange/table.h"

namespace stillpoint::exchange {

struct SensorColumns {
  Quantity quantity = Quantity::kAcc;
  std::vector<std::string> columns;  ///< three, one for temp
  std::string unit;                  ///< empty: by the values
  std::string table;                 ///< part of the file's name, where several tables have the same columns
};

struct ColumnMap {
  std::string time;       ///< column; empty: found by name
  std::string time_unit;  ///< s, ms, us, ns; empty: by the name or the values
  std::vector<SensorColumns> sensors;
  Mat3 R_body_sensor = Mat3::Identity();  ///< axes of the file's program to ours
};

/// Reads {time: {column: t, unit: ns}, acc: {columns: [ax, ay, az], unit: g, file: Accelerometer}, temp: {column: T},
/// mount: "+x -y -z"}. Fails with 66, 78: every fault as file:line:column.
[[nodiscard]] Result<ColumnMap> read_column_map(const std::string& path);

/// What the names of the columns say; nothing of what cannot be told.
[[nodiscard]] ColumnMap guess(const Table& table);

/// Factor to SI (uT, degC) of a unit by any of its spellings; 0: none that is known.
[[nodiscard]] double factor_of(Quantity quantity, const std::string& unit);
[[nodiscard]] double time_factor_ns(const std::string& unit);

/// The unit in a column's name, in brackets or as its last part; empty without one.
[[nodiscard]] std::string unit_in(const std::string& column);

/// How much a column's name says that it is the time; 0: nothing.
[[nodiscard]] int rank_as_time(const std::string& name);
/// The column that is the time, by its name; empty without one.
[[nodiscard]] std::string time_column(const Table& table);

}  // namespace stillpoint::exchange
