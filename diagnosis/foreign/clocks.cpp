#include "diagnosis/foreign/clocks.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "diagnosis/reference/differences.h"

namespace stillpoint::diag {
namespace {

constexpr double kCoarse_s = 0.05;
constexpr Eigen::Index kReach = 4;  // rows on either side of a value between rows

/// The norm at every coarse step, as the mean of the rows there.
Series coarse_norm(const Course& c) {
  const auto n = static_cast<Eigen::Index>(c.end_s() / kCoarse_s) + 1;
  Series sum = Series::Zero(n), count = Series::Zero(n);
  for (Eigen::Index i = 0; i < c.x.rows(); ++i) {
    const auto at = std::min(n - 1, static_cast<Eigen::Index>(c.rows.at(i) / kCoarse_s));
    sum[at] += c.x.row(i).norm(), count[at] += 1.0;
  }
  for (Eigen::Index i = 0; i < n; ++i) sum[i] = count[i] > 0 ? sum[i] / count[i] : i > 0 ? sum[i - 1] : 0.0;
  return sum;
}

double correlation(const Eigen::Ref<const Series>& a, const Eigen::Ref<const Series>& b) {
  const Series x = a.array() - a.mean(), y = b.array() - b.mean();
  return x.dot(y) / std::max(x.norm() * y.norm(), 1e-300);
}

}  // namespace

Clocks coarse_clocks(const Course& log, const Course& recording) {
  const Series a = coarse_norm(log), b = coarse_norm(recording);
  const Eigen::Index least = std::max<Eigen::Index>(20, std::min(a.size(), b.size()) / 2);
  Clocks best;
  double most = -2.0;
  for (Eigen::Index shift = least - b.size(); shift <= a.size() - least; ++shift) {
    const Eigen::Index from = std::max<Eigen::Index>(shift, 0), to = std::min(a.size(), b.size() + shift);
    if (to - from < least) continue;
    const double c = correlation(a.segment(from, to - from), b.segment(from - shift, to - from));
    if (c <= most) continue;
    most = c;
    best = {static_cast<double>(shift) * kCoarse_s, 0.0, c, static_cast<double>(to - from) * kCoarse_s};
  }
  return best;
}

Series3 at_rows_of(const Course& recording, const Course& log, const Clocks& clocks) {
  Series at(recording.x.rows());
  for (Eigen::Index i = 0; i < at.size(); ++i) at[i] = clocks.offset_s + (1.0 + clocks.drift) * recording.rows.at(i);
  return at_times(log.x, log.rows, at, kReach);
}

void refine_clocks(const Course& log, const Course& recording, Clocks& clocks) {
  constexpr int kRounds = 8;
  const Course slope{derivative(log.x, log.rows), log.rows};
  const Eigen::Index n = recording.x.rows();
  for (int round = 0; round < kRounds; ++round) {
    const Series3 y = at_rows_of(recording, log, clocks), d = at_rows_of(recording, slope, clocks);
    Eigen::MatrixXd map(n, 4);
    map << Series::Ones(n), y;
    std::vector<Eigen::Index> inside;
    for (Eigen::Index i = 0; i < n; ++i) {
      const double at = clocks.offset_s + (1.0 + clocks.drift) * recording.rows.at(i);
      if (at > 0.5 && at < log.end_s() - 0.5) inside.push_back(i);
    }
    if (inside.size() < 50) return;
    const Eigen::MatrixXd used = map(inside, Eigen::all);
    const Eigen::MatrixXd A = used.colPivHouseholderQr().solve(Eigen::MatrixXd(recording.x(inside, Eigen::all)));
    const Series3 left = recording.x - map * A;
    const Series3 turned = d * A.bottomRows(3);
    Eigen::Matrix2d G = Eigen::Matrix2d::Zero();
    Eigen::Vector2d g = Eigen::Vector2d::Zero();
    const double middle = 0.5 * recording.end_s();
    for (const Eigen::Index i : inside) {
      const Eigen::Vector2d u(1.0, (recording.rows.at(i) - middle) / std::max(middle, 1e-9));
      G += u * u.transpose() * turned.row(i).squaredNorm();
      g += u * turned.row(i).dot(left.row(i));
    }
    const Eigen::Vector2d step = G.ldlt().solve(g).cwiseMax(-0.1).cwiseMin(0.1);
    const double drift = step[1] / std::max(middle, 1e-9);
    clocks.offset_s += step[0] - drift * middle;
    clocks.drift += drift;
    if (step.cwiseAbs().maxCoeff() < 1e-7) return;
  }
}

}  // namespace stillpoint::diag
