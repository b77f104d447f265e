#include "diagnosis/discovery/law_delta.h"

#include <algorithm>

#include "diagnosis/discovery/drivers.h"
#include "simulation/law_effect.h"

namespace stillpoint::diag {
namespace {

/// A number stands in all three columns.
Series3 in_three(const Eigen::MatrixXd& x) { return x.cols() == 3 ? Series3(x) : Series3(x.replicate(1, 3)); }

Series3 tabulated(const sim::EffectConfig& entry, Series3 x) {
  const auto curves = sim::curves_of(entry);
  for (std::size_t axis = 0; axis < curves.size(); ++axis)
    for (double& v : x.col(static_cast<Eigen::Index>(axis))) v = curves[axis].at(v);
  return x;
}

}  // namespace

std::optional<Series3> law_delta(const Signals& s, Sensor sensor, const sim::EffectConfig& entry) {
  const bool law = sim::is_law(entry);
  if (!law && !sim::is_table(entry)) return std::nullopt;
  if (entry.sensors.empty() || static_cast<int>(entry.sensors.front()) != static_cast<int>(sensor)) return std::nullopt;
  const auto tree = sim::tree_of(entry);
  const laws::Columns drivers = drivers_of_rows(s);
  const auto absent = [&](const std::string& name) { return name != "t" && !drivers.values.contains(name); };
  const auto names = tree ? laws::drivers_of(*tree) : std::vector<std::string>{};
  if (!tree || std::any_of(names.begin(), names.end(), absent)) return std::nullopt;
  Series3 out = in_three(laws::evaluate(*tree, drivers));
  if (law) {
    const laws::Coupled c = sim::coupled(entry);
    const Mat3 map = c.has_matrix ? Mat3(mat(c.matrix)) : Mat3(Vec3(c.matrix.data()).asDiagonal());
    out = out * map.transpose();
  } else {
    out = tabulated(entry, std::move(out));
  }
  for (Eigen::Index i = 0; i < s.n && entry.window_s; ++i)
    if (s.t_s[i] < entry.window_s->first || s.t_s[i] > entry.window_s->second) out.row(i).setZero();
  for (int axis = 0; axis < 3; ++axis)
    if (!entry.axes.empty() && std::find(entry.axes.begin(), entry.axes.end(), axis) == entry.axes.end())
      out.col(axis).setZero();
  return out;
}

}  // namespace stillpoint::diag
