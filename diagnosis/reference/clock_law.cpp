#include "diagnosis/reference/clock_law.h"

#include <Eigen/LU>
#include <cmath>

#include "diagnosis/reference/columns.h"
#include "diagnosis/result.h"

namespace stillpoint::diag {

Eigen::MatrixXd lateness(const Signals& s, const Found& f) {
  Eigen::MatrixXd late = Eigen::MatrixXd::Zero(s.n, f.timing.size() == 2 && f.id != "sys_skew" ? 0 : f.timing.size());
  if (late.cols() == 0) return late;
  const Eigen::Index begin = f.window.local ? f.window.begin : 0, end = f.window.local ? f.window.end : s.n;
  late.col(0).segment(begin, end - begin).setOnes();
  if (f.id != "sys_skew") return late;
  late.col(0).setLinSpaced(0.0, s.duration_s());
  if (late.cols() == 2) late.col(1) = integral(s.temperature_K, s.dt_s);
  return late;
}

double most_late(const Signals& s, const Found& f, const Eigen::VectorXd& numbers) {
  const bool clock = is_delay(f.id) || f.id == "sys_skew";
  return clock ? (lateness(s, f) * numbers).cwiseAbs().maxCoeff() : HUGE_VAL;
}

Eigen::VectorXd chance_by_jitter(const Signals& s, const Found& f, const Layout& layout) {
  if (s.jitter_sd_s == 0.0 || f.kind != Kind::kTiming) return {};
  const Eigen::MatrixXd late = lateness(s, f);
  if (late.cols() == 0) return {};
  const Eigen::MatrixXd told = late.transpose() * layout.counts.matrix().asDiagonal() * late;
  return s.jitter_sd_s * told.inverse().diagonal().cwiseMax(0.0).cwiseSqrt();
}

}  // namespace stillpoint::diag
