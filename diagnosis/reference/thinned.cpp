#include "diagnosis/reference/signals.h"

namespace stillpoint::diag {
namespace {

/// Means over the samples that are measurements; where a group has none, over all of it (it is muted then). A sensor
/// that the recording lacks has a prediction and no mask.
Series3 means_of_measured(const Series3& x, const Mask& muted, Eigen::Index factor) {
  Series3 out = means_of_rows(x, factor);
  if (muted.empty()) return out;
  for (Eigen::Index i = 0; i < out.rows(); ++i) {
    Vec3 sum = Vec3::Zero();
    double count = 0;
    for (Eigen::Index k = i * factor; k < (i + 1) * factor; ++k)
      if (!muted[static_cast<std::size_t>(k)]) sum += x.row(k).transpose(), ++count;
    if (count > 0) out.row(i) = sum.transpose() / count;
  }
  return out;
}

/// Set where every sample of the group is.
Mask merged(const Mask& mask, Eigen::Index factor) {
  const std::size_t step = static_cast<std::size_t>(factor), n = mask.size() / step;
  Mask out(n, 1);
  for (std::size_t i = 0; i < n * step; ++i)
    if (!mask[i]) out[i / step] = 0;
  return out;
}

}  // namespace

Signals thinned(const Signals& s, Eigen::Index factor) {
  Signals out = s;
  out.n = s.n / factor;
  out.dt_s = out.rows.step_s = s.dt_s * static_cast<double>(factor);
  out.rows.t_s = means_of_rows(s.rows.t_s, factor);
  out.t_s = means_of_rows(s.t_s, factor);
  for (auto* group : {&out.reading, &out.predicted, &out.residual})
    for (std::size_t k = 0; k < group->size(); ++k) (*group)[k] = means_of_measured((*group)[k], s.muted[k], factor);
  for (auto* group : {&out.vector, &out.world_axis, &out.edges_of_rests})
    for (Series3& x : *group) x = means_of_rows(x, factor);
  for (Series3* x : {&out.rate, &out.rate_dot, &out.position_m, &out.vibration, &out.given_rate})
    *x = means_of_rows(*x, factor);
  for (Series* x : {&out.temperature_K, &out.current_A, &out.voltage_V}) *x = means_of_rows(*x, factor);
  for (auto& [name, x] : out.user) x = means_of_rows(x, factor);
  for (Mask& m : out.muted) m = merged(m, factor);
  out.rest = merged(s.rest, factor);
  out.by_times.fill({});  // means of rows are not timed again
  return out;
}

}  // namespace stillpoint::diag
