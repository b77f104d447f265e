#include "diagnosis/discovery/term.h"

#include <fmt/format.h>

#include <algorithm>

#include "diagnosis/discovery/open_numbers.h"
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

/// Of what is compared with this number, or divided by it.
std::string unit_beside(const laws::Node& n, double number) {
  using enum laws::Op;
  const bool own = n.args.size() == 2 && n.args[1].op == kNumber && n.args[1].number == number;
  if (own && (n.op == kLag || n.op == kDelay)) return "s";
  if (own && (n.op == kStep || n.op == kPlay || n.op == kDivide)) return laws::text(n.args[0].unit);
  for (const laws::Node& a : n.args)
    if (std::string unit = unit_beside(a, number); !unit.empty()) return unit;
  return "";
}

/// The numbers inside of a formula, each with a name of its own.
std::vector<InnerNumber> inner_numbers(const laws::Node& tree, const std::string& text, bool matrix,
                                       const std::shared_ptr<const laws::Columns>& drivers) {
  std::vector<InnerNumber> out;
  for (const OpenNumber& n : open_numbers(text)) {
    const auto alike =
        std::count_if(out.begin(), out.end(), [&n](const auto& o) { return o.name.starts_with(n.name); });
    const double value = std::stod(n.digits);
    out.push_back({alike > 0 ? fmt::format("{}_{}", n.name, alike + 1) : n.name, unit_beside(tree, value), value,
                   [text, digits = n.digits, matrix, drivers](double x) {
                     const std::string other = with_number(text, digits, fmt::format("{:.15g}", x));
                     return columns_of_value(laws::evaluate(*laws::parse(other, signature_of(*drivers)), *drivers),
                                             matrix);
                   }});
  }
  return out;
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
    f.inner = inner_numbers(*tree, text, term.idea.matrix, drivers);
    out.push_back(std::move(f));
  }
  return out;
}

}  // namespace stillpoint::diag
