#include "report/plot.h"

#include <algorithm>
#include <numeric>

namespace stillpoint::report {

Plot in_order_of_x(Plot plot) {
  std::vector<std::size_t> order(plot.x.size());
  std::iota(order.begin(), order.end(), 0U);
  std::stable_sort(order.begin(), order.end(), [&plot](std::size_t a, std::size_t b) { return plot.x[a] < plot.x[b]; });
  const auto reordered = [&order](const std::vector<double>& values) {
    std::vector<double> out;
    out.reserve(order.size());
    for (const std::size_t i : order) out.push_back(values[i]);
    return out;
  };
  plot.x = reordered(plot.x);
  for (Curve& c : plot.curves) c.y = reordered(c.y);
  return plot;
}

}  // namespace stillpoint::report
