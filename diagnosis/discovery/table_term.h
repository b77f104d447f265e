/// Where no formula is good enough: a free function of one driver, through points.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "diagnosis/reference/columns.h"

namespace stillpoint::diag {

/// Where the points of a table of this driver lie: as many between any two of them, none closer than a share of the
/// range; empty where fewer than four are left.
[[nodiscard]] std::vector<double> table_points(const Eigen::MatrixXd& driver);

/// The points whose values are coefficients: all but the middle one, as a constant is fitted beside every hypothesis.
[[nodiscard]] std::vector<std::size_t> free_points(std::size_t points);

/// Straight from point to point, each axis with coefficients of its own: first all of x, then y, z.
[[nodiscard]] Columns table_columns(const Series& driver, const std::vector<double>& points);

/// "table(T)" and back: nullopt where it is no table.
[[nodiscard]] std::string table_text(const std::string& driver);
[[nodiscard]] std::optional<std::string> driver_of_table(const std::string& text);

}  // namespace stillpoint::diag
