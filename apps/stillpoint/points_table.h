/// Tables of static readings, x,y,z and perhaps their variance, as `stillpoint calibrate --points` takes them.
#pragma once
#include <string>
#include <vector>

#include "calib_online/offline/points_fit.h"
#include "core/result.h"

namespace stillpoint::app {

struct PointsTable {
  std::vector<calib::Point> points;
  std::vector<std::string> faults;  ///< "file:line:column: ..." of the lines that are no point
};

/// Fails with 66 (no file) or 65 (no header with x, y and z).
[[nodiscard]] Result<PointsTable> read_points(const std::string& path);
/// The same from text already in memory; `name` stands for the file in messages.
[[nodiscard]] Result<PointsTable> parse_points(const std::string& text, const std::string& name);

}  // namespace stillpoint::app
