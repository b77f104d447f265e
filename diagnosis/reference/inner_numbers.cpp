#include "diagnosis/reference/inner_numbers.h"

#include <algorithm>
#include <cmath>

namespace stillpoint::diag {
namespace {

/// Deviations from fits that leave out one tenth of the recording each (delete-a-group jackknife: Kott 2001): they hold
/// what a law itself gets wrong from one stretch to the next.
Eigen::VectorXd jackknife_sd(const Target& t, const Columns& columns, const NoiseModel& noise,
                             const std::array<double, 3>& walk_q) {
  constexpr Eigen::Index kGroups = 10;
  constexpr double kStudent = 2.262 / 1.960;  // ten groups know their own scatter to nine degrees of freedom
  const auto p = static_cast<Eigen::Index>(columns.size());
  Eigen::MatrixXd theta(p, kGroups);
  for (Eigen::Index g = 0; g < kGroups; ++g) {
    Target part = t;
    const Eigen::Index begin = g * t.layout.n / kGroups, end = (g + 1) * t.layout.n / kGroups;
    part.layout.counts.segment(begin, end - begin).setZero();
    theta.col(g) = fit_with(part, columns, noise, walk_q).theta;
  }
  const Eigen::VectorXd mean = theta.rowwise().mean();
  const double share = static_cast<double>(kGroups - 1) / static_cast<double>(kGroups);
  return kStudent * (share * (theta.colwise() - mean).rowwise().squaredNorm()).cwiseSqrt();
}

/// A number inside of a law, and how far to either side its tangent looks.
struct Freed {
  std::size_t effect;  ///< whose it is
  InnerNumber number;
  Eigen::VectorXd k;  ///< of its law
  bool discovered;    ///< its law may answer by jumps
  double step;
  double least = 0.0;  ///< within less than this the law does not change

  [[nodiscard]] Series3 law(Eigen::Index n, double other) const {
    const Columns columns = number.columns(other);
    Series3 out = Series3::Zero(n, 3);
    for (std::size_t j = 0; j < columns.size(); ++j)
      for (int axis = 0; axis < 3; ++axis)
        if (const auto x = shown_in(columns[j], axis)) out.col(axis) += k[static_cast<Eigen::Index>(j)] * *x;
    return out;
  }
  [[nodiscard]] double farthest() const { return 0.5 * std::abs(number.value); }
  /// Zero where the law does not change at all. Between two rows a moment may lie anywhere.
  [[nodiscard]] Column tangent(Eigen::Index n) {
    const Series3 now = law(n, number.value);
    Series3 up = law(n, number.value + step), down = law(n, number.value - step);
    while ((up == now || down == now) && step < farthest()) {
      least = step *= 2.0;
      up = law(n, number.value + step), down = law(n, number.value - step);
    }
    return {-1, (up - down) / (2.0 * step)};
  }
  void span(double sd) {
    if (discovered && sd > 0.0) step = std::min(sd, farthest());
  }
};

std::vector<Freed> freed_numbers(const SensorSearch& search, const Eigen::VectorXd& theta) {
  std::vector<Freed> out;
  for (std::size_t i = 0; i < search.found.size(); ++i) {
    const Found& f = search.found[i];
    const Eigen::VectorXd k = theta.segment(first_column(search, i), static_cast<Eigen::Index>(f.columns.size()));
    const auto add = [&](const InnerNumber& number, bool discovered) {
      Freed freed{i, number, k, discovered, 1e-3 * std::abs(number.value)};
      if (freed.step > 0.0 && !freed.tangent(search.target.layout.n).x.isZero(0.0)) out.push_back(std::move(freed));
    };
    for (const InnerNumber& number : f.inner) add(number, true);
    // A level of clipping has a shape too, but its likelihood has a kink at every sample.
    if (f.at_shape && f.shape_unit == "s") add({f.shape_name, f.shape_unit, f.shape, f.at_shape}, false);
  }
  return out;
}

}  // namespace

void free_inner_numbers(const SensorSearch& search, const Target& t, Finished& out) {
  const Columns explained = search.explained();
  const auto p = static_cast<Eigen::Index>(explained.size());
  std::vector<Freed> freed = freed_numbers(search, out.fit.theta);
  out.inner_sd.assign(search.found.size(), {});
  if (freed.empty()) return;
  const NoiseModel noise(t.layout, out.fit.leftover);
  Eigen::VectorXd sd;
  const bool may_jump = std::any_of(freed.begin(), freed.end(), [](const Freed& f) { return f.discovered; });
  for (int rounds = may_jump ? 3 : 1; rounds > 0; --rounds) {
    Columns columns = explained;
    for (Freed& f : freed) columns.push_back(f.tangent(t.layout.n));
    const Fit wide = fit_with(t, columns, noise, out.fit.walk_q);
    sd = wide.covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
    // The search looks for one number at a time: it may stop short of where all together would lie.
    for (std::size_t k = 0; k < freed.size(); ++k) {
      const auto at = p + static_cast<Eigen::Index>(k);
      if (freed[k].discovered) sd[at] = std::hypot(sd[at], wide.theta[at]);
    }
    const Eigen::MatrixXd robust = robust_covariance(t, columns, noise, out.fit.walk_q);
    if (robust.size() > 0) sd = sd.cwiseMax(robust.diagonal().cwiseMax(0.0).cwiseSqrt());
    // When an estimator on board believes in a rest is its own secret, and every rest goes a little its own way.
    const auto behind_tracker = [](const Found& f) { return f.shape_name == kTrackerShape; };
    if (std::any_of(search.found.begin(), search.found.end(), behind_tracker))
      sd = sd.cwiseMax(jackknife_sd(t, columns, noise, out.fit.walk_q));
    for (std::size_t k = 0; k < freed.size(); ++k) freed[k].span(sd[p + static_cast<Eigen::Index>(k)]);
  }
  out.sd = sd.head(p);
  for (std::size_t k = 0; k < freed.size(); ++k)
    out.inner_sd[freed[k].effect][freed[k].number.name] =
        std::max(sd[p + static_cast<Eigen::Index>(k)], freed[k].least);
}

}  // namespace stillpoint::diag
