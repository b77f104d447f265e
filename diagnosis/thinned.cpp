#include "diagnosis/signals.h"

namespace stillpoint::diag {
namespace {

template <class Matrix>
Matrix means(const Matrix& x, Eigen::Index factor) {
  if (x.rows() == 0) return x;
  const Eigen::Index n = x.rows() / factor;
  Matrix out = Matrix::Zero(n, x.cols());
  for (Eigen::Index i = 0; i < n; ++i) out.row(i) = x.middleRows(i * factor, factor).colwise().mean();
  return out;
}

Mask merged(const Mask& mask, Eigen::Index factor, bool all) {
  const std::size_t step = static_cast<std::size_t>(factor), n = mask.size() / step;
  Mask out(n, all ? 1 : 0);
  for (std::size_t i = 0; i < n * step; ++i) {
    if (all && !mask[i]) out[i / step] = 0;
    if (!all && mask[i]) out[i / step] = 1;
  }
  return out;
}

}  // namespace

Signals thinned(const Signals& s, Eigen::Index factor) {
  Signals out = s;
  out.n = s.n / factor;
  out.dt_s = s.dt_s * static_cast<double>(factor);
  out.t_s = means(s.t_s, factor);
  for (auto* group : {&out.reading, &out.predicted, &out.residual, &out.vector, &out.world_axis})
    for (Series3& x : *group) x = means(x, factor);
  for (Series3* x : {&out.rate, &out.rate_dot, &out.position_m, &out.vibration}) *x = means(*x, factor);
  for (Series* x : {&out.temperature_K, &out.current_A, &out.voltage_V}) *x = means(*x, factor);
  for (Mask& m : out.muted) m = merged(m, factor, false);
  out.rest = merged(s.rest, factor, true);
  return out;
}

}  // namespace stillpoint::diag
