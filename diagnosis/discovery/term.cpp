#include "diagnosis/discovery/term.h"

#include <fmt/format.h>

#include "diagnosis/discovery/table_term.h"
#include "diagnosis/discovery/term_scan.h"

namespace stillpoint::diag {
namespace {

/// The points stand beside the coefficients, the one that is the table's zero among them.
void as_table(const std::vector<double>& points, Sensor sensor, Found& f) {
  f.id = "unknown:" + table_text(f.driver);
  f.equation = fmt::format(
      "delta = a free function of {} between {:.4g} and {:.4g}, through {} points an axis; no formula "
      "that was tried explains as much",
      f.driver, points.front(), points.back(), points.size());
  for (std::size_t i = 0; i < points.size(); ++i) f.fixed[fmt::format("x{}", i)] = points[i];
  f.names.clear();
  for (const char* axis : kAxisName)
    for (const std::size_t at : free_points(points.size()))
      f.names.push_back(fmt::format("y_{}({:.4g})", axis, points[at]));
  f.unit = kSensorUnit[sensor];
  f.units.assign(f.names.size(), f.unit);
}

}  // namespace

Columns columns_of(const Idea& idea, const Eigen::MatrixXd& value) {
  if (!idea.points.empty()) return table_columns(value.col(0), idea.points);
  return columns_of_value(value, idea.matrix);
}

std::vector<Found> effects_of(const Term& term, Sensor sensor, const std::shared_ptr<const laws::Columns>& drivers) {
  std::vector<Found> out;
  const laws::Signature signature = signature_of(*drivers);
  std::size_t next = 0;
  for (std::size_t part = 0; part < term.idea.texts.size(); ++part) {
    const std::string text = term.idea.text(part, term.shape);
    const auto tree = laws::parse(text, signature);
    if (!tree) continue;
    Found f = term.found;
    const std::size_t count = term.found.columns.size() / term.idea.texts.size();
    f.columns.assign(term.found.columns.begin() + static_cast<std::ptrdiff_t>(next),
                     term.found.columns.begin() + static_cast<std::ptrdiff_t>(next + count));
    next += count;
    f.driver = text;
    if (!term.idea.points.empty()) {
      as_table(term.idea.points, sensor, f);
      out.push_back(std::move(f));
      continue;
    }
    f.id = "unknown:" + text;
    f.equation = "delta = k " + text;
    f.names = count == 9
                  ? std::vector<std::string>{"k_xx", "k_xy", "k_xz", "k_yx", "k_yy", "k_yz", "k_zx", "k_zy", "k_zz"}
                  : std::vector<std::string>{"k_x", "k_y", "k_z"};
    const std::string of = laws::text(tree->unit);
    f.unit = of == "1" ? std::string(kSensorUnit[sensor]) : std::string(kSensorUnit[sensor]) + " per " + of;
    f.units.assign(count, f.unit);
    if (!term.idea.shape_name.empty()) {
      f.shape_name = term.idea.shape_name;
      f.shape_unit = term.idea.shape_unit;
      if (f.shape_name == "tau")
        f.at_shape = [idea = term.idea, part, drivers, signature](double shape) {
          const auto at = laws::parse(idea.text(part, shape), signature);
          return columns_of(idea, laws::evaluate(*at, *drivers));
        };
    }
    out.push_back(std::move(f));
  }
  return out;
}

}  // namespace stillpoint::diag
