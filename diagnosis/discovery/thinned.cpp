#include "diagnosis/discovery/thinned.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/reference/scan_noise.h"

namespace stillpoint::diag {
namespace {

/// The rows of a search with what it has subtracted so far.
Signals with_residual(const Signals& s, const SensorSearch& base) {
  Signals out = s;
  out.residual[base.sensor] = base.target.residual;
  return out;
}

}  // namespace

Rows::Rows(const Signals& s, const laws::Columns& full, double rows)
    : factor(std::max<Eigen::Index>(1, std::lround(static_cast<double>(s.n) / rows))) {
  drivers.t_s = means_of_rows(full.t_s, factor);
  for (const auto& [name, x] : full.values) drivers.values[name] = means_of_rows(x, factor);
}

Thin::Thin(const Signals& full, const SensorSearch& base, Eigen::Index factor, bool walks)
    : s(factor > 1 ? thinned(with_residual(full, base), factor) : with_residual(full, base)) {
  target = make_target(s, base.sensor);
  for (const Column& c : base.explained()) explained.push_back({c.axis, means_of_rows(c.x, factor)});
  null = target;
  const WalkBasis walk = walk_basis(s);
  if (walks) null.walk = walk;
  white = target;
  white.layout.order = 0;
  noises.reserve(3), all.reserve(3);
  noises.emplace_back(null.layout, fit_profile(null, explained).leftover);
  noises.push_back(scan_noise(target, explained, *walk));
  const NoiseModel level(white.layout, white.residual);
  noises.emplace_back(white.layout, fit_with(white, explained, level, {}).leftover);
  all.emplace_back(null, explained, noises[0]);
  all.emplace_back(target, explained, noises[1]);
  all.emplace_back(white, explained, noises[2]);
}

}  // namespace stillpoint::diag
