#include "apps/stillpoint/points_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <sstream>

#include "io/quote.h"
#include "io/text_file.h"

namespace stillpoint::app {
namespace {

std::vector<std::string> split(std::string line) {
  if (!line.empty() && line.back() == '\r') line.pop_back();
  std::vector<std::string> out;
  std::stringstream in(line);
  for (std::string cell; std::getline(in, cell, ',');) {
    const auto first = cell.find_first_not_of(" \t\""), last = cell.find_last_not_of(" \t\"");
    out.push_back(first == std::string::npos ? "" : cell.substr(first, last - first + 1));
  }
  if (!line.empty() && line.back() == ',') out.emplace_back();
  return out;
}

std::optional<double> number(const std::string& text) {
  if (text.empty()) return std::nullopt;
  const char* begin = text.c_str();
  char* end = nullptr;
  const double value = std::strtod(begin, &end);
  if (end != begin + text.size()) return std::nullopt;
  return value;
}

/// One line of numbers into a point; faults name the column.
void read_line(const std::vector<std::string>& cells, const std::vector<std::string>& header, const std::string& where,
               PointsTable& table) {
  calib::Point point;
  if (cells.size() != header.size()) {
    table.faults.push_back(fmt::format("{}:1: {} fields, the header has {}", where, cells.size(), header.size()));
    return;
  }
  bool good = true;
  for (std::size_t k = 0; k < header.size(); ++k) {
    const bool axis = header[k] == "x" || header[k] == "y" || header[k] == "z";
    const bool known = axis || header[k] == "var";
    if (!known || (!axis && cells[k].empty())) continue;
    const auto value = number(cells[k]);
    if (!value || !std::isfinite(*value)) {
      table.faults.push_back(
          fmt::format("{}:{}: {} is {}, not a finite number", where, k + 1, header[k], io::quote(cells[k])));
      good = false;
      continue;
    }
    if (header[k] == "var")
      point.variance = *value;
    else
      point.y[header[k][0] - 'x'] = *value;
  }
  if (good) table.points.push_back(point);
}

}  // namespace

Result<PointsTable> parse_points(const std::string& text, const std::string& name) {
  std::istringstream in(text);
  PointsTable table;
  std::vector<std::string> header;
  std::size_t number_of_line = 0;
  for (std::string line; std::getline(in, line);) {
    ++number_of_line;
    if (line.rfind("\xEF\xBB\xBF", 0) == 0) line.erase(0, 3);
    if (line.find_first_not_of(" \t\r") == std::string::npos || line[0] == '#') continue;
    const auto cells = split(line);
    if (header.empty()) {
      header = cells;
      for (const char* axis : {"x", "y", "z"})
        if (std::count(header.begin(), header.end(), axis) != 1)
          return fail(ErrorKind::kBadData, fmt::format("{}:{}:1: the header needs one column '{}'; it is {}", name,
                                                       number_of_line, axis, io::quote(line)));
      continue;
    }
    read_line(cells, header, fmt::format("{}:{}", name, number_of_line), table);
  }
  if (header.empty()) return fail(ErrorKind::kBadData, name + ":1:1: the file is empty; a header x,y,z is needed");
  return table;
}

Result<PointsTable> read_points(const std::string& path) {
  const auto text = io::read_text_file(path, "a table of points (.csv)");
  if (!text) return tl::unexpected(text.error());
  return parse_points(*text, path);
}

}  // namespace stillpoint::app
