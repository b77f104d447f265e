#include "diagnosis/foreign/clocks.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <vector>

#include "diagnosis/reference/differences.h"
#include "diagnosis/reference/prediction.h"

namespace stillpoint::diag {
namespace {

constexpr double kCoarse_s = 0.05;
constexpr Eigen::Index kReach = 4;  // rows on either side of a value between rows
constexpr std::size_t kParts = 10;  // of the recording, each left out once
constexpr double kSurely = 5.0;     // standard deviations between two clocks
constexpr double kGapSteps = 4.0;   // of the log in the mean, from one reading to the next

/// The norm at every coarse step, as the mean of the rows there; a straight line where there are none.
Series coarse_norm(const Course& c) {
  const auto n = static_cast<Eigen::Index>(c.end_s() / kCoarse_s) + 1;
  Series sum = Series::Zero(n), count = Series::Zero(n);
  for (Eigen::Index i = 0; i < c.x.rows(); ++i) {
    const auto at = std::min(n - 1, static_cast<Eigen::Index>(c.rows.at(i) / kCoarse_s));
    sum[at] += c.x.row(i).norm(), count[at] += 1.0;
  }
  return filled(n, [&](Eigen::Index i) { return sum[i] / count[i]; });
}

double correlation(const Eigen::Ref<const Series>& a, const Eigen::Ref<const Series>& b) {
  const Series x = a.array() - a.mean(), y = b.array() - b.mean();
  return x.dot(y) / std::max(x.norm() * y.norm(), 1e-300);
}

/// Normal equations of a step of the clock, in seconds at the middle of the recording and at its end beside that.
struct Step {
  Eigen::Matrix2d G = Eigen::Matrix2d::Zero();
  Eigen::Vector2d g = Eigen::Vector2d::Zero();

  [[nodiscard]] Eigen::Vector2d solve() const { return G.ldlt().solve(g).cwiseMax(-0.1).cwiseMin(0.1); }
};

/// Of each part of the recording, beside one linear map of the log; nothing where they hardly overlap.
std::vector<Step> steps_of_parts(const Course& log, const Course& slope, const Course& recording,
                                 const Clocks& clocks) {
  const Mask unread = unread_at_rows_of(recording, log, clocks);
  const Series3 y = at_rows_of(recording, log, clocks, unread), d = at_rows_of(recording, slope, clocks, unread);
  const Eigen::Index n = recording.x.rows();
  Eigen::MatrixXd map(n, 4);
  map << Series::Ones(n), y;
  std::vector<Eigen::Index> inside;
  for (Eigen::Index i = 0; i < n; ++i)
    if (const double at = clocks.at(recording.rows.at(i));
        at > 0.5 && at < log.end_s() - 0.5 && !unread[static_cast<std::size_t>(i)])
      inside.push_back(i);
  if (inside.size() < 50) return {};
  const Eigen::MatrixXd used = map(inside, Eigen::all);
  const Eigen::MatrixXd A = used.colPivHouseholderQr().solve(Eigen::MatrixXd(recording.x(inside, Eigen::all)));
  const Series3 left = recording.x - map * A;
  const Series3 turned = d * A.bottomRows(3);
  std::vector<Step> out(kParts);
  for (std::size_t k = 0; k < inside.size(); ++k) {
    const Eigen::Index i = inside[k];
    const Eigen::Vector2d u(1.0, (recording.rows.at(i) - clocks.middle_s) / std::max(clocks.middle_s, 1e-9));
    Step& part = out[k * kParts / inside.size()];
    part.G += u * u.transpose() * turned.row(i).squaredNorm();
    part.g += u * turned.row(i).dot(left.row(i));
  }
  return out;
}

/// The sum of them without one; with all where that is none of them.
Step without(const std::vector<Step>& parts, std::size_t part) {
  Step out;
  for (std::size_t i = 0; i < parts.size(); ++i)
    if (i != part) out.G += parts[i].G, out.g += parts[i].g;
  return out;
}

/// Jackknife: what leaving out each part moves.
Eigen::Vector2d deviations(const std::vector<Step>& parts) {
  Eigen::MatrixX2d left_out(static_cast<Eigen::Index>(parts.size()), 2);
  for (std::size_t i = 0; i < parts.size(); ++i)
    left_out.row(static_cast<Eigen::Index>(i)) = without(parts, i).solve().transpose();
  const Eigen::MatrixX2d off = left_out.rowwise() - left_out.colwise().mean();
  const auto n = static_cast<double>(parts.size());
  return ((n - 1.0) / n * off.colwise().squaredNorm()).cwiseSqrt().transpose();
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

Mask unread_at_rows_of(const Course& recording, const Course& log, const Clocks& clocks) {
  const Series& read_s = log.rows.t_s;
  Mask gap_after(static_cast<std::size_t>(read_s.size()), 0);
  for (Eigen::Index i = 0; i + 1 < read_s.size(); ++i)
    if (read_s[i + 1] - read_s[i] > kGapSteps * log.rows.step_s) gap_after[static_cast<std::size_t>(i)] = 1;
  Mask beside(gap_after.size(), 0);
  mute_beside(gap_after, kStencilReach, beside);
  Mask out(static_cast<std::size_t>(recording.x.rows()));
  for (std::size_t i = 0; i < out.size(); ++i) {
    const double at = clocks.at(recording.rows.at(static_cast<Eigen::Index>(i)));
    const auto before = std::upper_bound(read_s.begin(), read_s.end(), at) - read_s.begin() - 1;
    out[i] = before < 0 || at > log.end_s() || beside[static_cast<std::size_t>(before)] ? 1 : 0;
  }
  return out;
}

Series3 at_rows_of(const Course& recording, const Course& log, const Clocks& clocks, const Mask& unread) {
  Series at(recording.x.rows());
  for (Eigen::Index i = 0; i < at.size(); ++i) at[i] = clocks.at(recording.rows.at(i));
  Series3 out = at_times(log.x, log.rows, at, kReach);
  for (int a = 0; a < 3; ++a)
    out.col(a) = filled(at.size(),
                        [&](Eigen::Index i) { return unread[static_cast<std::size_t>(i)] ? io::kMissing : out(i, a); });
  return out;
}

void refine_clocks(const Course& log, const Course& recording, Clocks& clocks) {
  constexpr int kRounds = 8;
  const Course slope{derivative(log.x, log.rows), log.rows};
  clocks.middle_s = 0.5 * recording.end_s();
  for (int round = 0; round < kRounds; ++round) {
    const std::vector<Step> parts = steps_of_parts(log, slope, recording, clocks);
    if (parts.empty()) return;
    const Eigen::Vector2d step = without(parts, parts.size()).solve();
    const double drift = step[1] / std::max(clocks.middle_s, 1e-9);
    clocks.offset_s += step[0] - drift * clocks.middle_s;
    clocks.drift += drift;
    const Eigen::Vector2d sd = deviations(parts);
    clocks.middle_sd_s = sd[0], clocks.drift_sd = sd[1] / std::max(clocks.middle_s, 1e-9);
    if (step.cwiseAbs().maxCoeff() < 1e-7) return;
  }
}

Clocks clocks_of_reference(const Course& log, const Course& reference, const Clocks& by_readings) {
  Clocks seen = by_readings;
  seen.middle_sd_s = seen.drift_sd = 1.0;
  refine_clocks(log, reference, seen);
  // The better known of the two, but the reference's where they surely differ.
  const auto better = [](double by_reference, double its_sd, double by_reading, double sd) {
    const bool apart = std::abs(by_reference - by_reading) > kSurely * std::hypot(its_sd, sd);
    return apart || its_sd < sd ? by_reference : by_reading;
  };
  const double middle = by_readings.middle_s;
  const double at_middle = better(seen.at(middle), seen.middle_sd_s, by_readings.at(middle), by_readings.middle_sd_s);
  Clocks out = by_readings;
  out.drift = better(seen.drift, seen.drift_sd, by_readings.drift, by_readings.drift_sd);
  out.offset_s = at_middle - (1.0 + out.drift) * middle;
  return out;
}

}  // namespace stillpoint::diag
