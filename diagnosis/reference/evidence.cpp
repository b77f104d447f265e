#include "diagnosis/reference/evidence.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/reference/fitted_matrix.h"
#include "diagnosis/reference/inner_numbers.h"

namespace stillpoint::diag {
namespace {

constexpr int kWhitenessLags = 20;
constexpr double kChiSquare20_999 = 45.31;

/// What deviations lack because the colour of the noise was estimated from what the same fit left over. An
/// autoregression of order p sees the slow band through n / 2p numbers an axis, of which the q coefficients took one
/// each, and knows its level there to a variance of 4 p / n (Berk, Annals of Statistics 2, 1974).
double estimated_colour(const Target& t, const Columns& columns) {
  const double q = static_cast<double>(t.nuisance.cols()) + static_cast<double>(columns.size()) / 3.0;
  return std::sqrt(1.0 + 2.0 * t.layout.order * (q + 2.0) / std::max(t.layout.used(), 1.0));
}

/// A lever along the axis of a turntable may be of 300 m: it does nothing there, and would ruin every other motion. A
/// coefficient that is known worse than the largest of its law that is told is taken to be of that size at most (a
/// normal prior); its interval stays as wide as the recording leaves it. The others follow as they are correlated.
void hold_what_is_not_told(const SensorSearch& search, Finished& out) {
  constexpr double kTold = 3.0, kFree = 1e3;  // deviations
  for (std::size_t i = 0; i < search.found.size(); ++i) {
    const Found& f = search.found[i];
    const auto first = first_column(search, i), count = static_cast<Eigen::Index>(f.columns.size());
    const bool alike = std::all_of(f.units.begin(), f.units.end(), [&f](const auto& u) { return u == f.units[0]; });
    if (f.timing.size() > 0 || count < 2 || !alike) continue;
    const Eigen::ArrayXd sd = out.sd.segment(first, count), size = out.values.segment(first, count).array().abs();
    const double told = (size > kTold * sd).select(size, 0.0).maxCoeff();
    if (told == 0.0 || (sd <= told).all()) continue;
    const Eigen::MatrixXd fitted = out.fit.covariance.block(first, first, count, count);
    const Eigen::ArrayXd widened = sd / fitted.diagonal().array().max(1e-300).sqrt();
    const Eigen::MatrixXd P = widened.matrix().asDiagonal() * fitted * widened.matrix().asDiagonal();
    const Eigen::VectorXd prior = (sd > told).select(Eigen::ArrayXd::Constant(count, told), kFree * sd).square();
    out.values.segment(first, count) = under_prior(out.values.segment(first, count), P, prior);
  }
}

}  // namespace

Eigen::Index first_column(const SensorSearch& search, std::size_t index) {
  Eigen::Index first = 0;
  for (std::size_t i = 0; i < index; ++i) first += static_cast<Eigen::Index>(search.found[i].columns.size());
  return first;
}

Finished finish(const SensorSearch& search) {
  const Columns explained = search.explained();
  Finished out;
  out.fit = fit_profile(search.target, explained);
  const Target t = search.beside_walk();
  Fit walking = fit_profile(t, explained);
  out.walk_gain_nats = walking.log_likelihood - out.fit.log_likelihood;
  if (out.walk_gain_nats > 0) out.fit = std::move(walking);
  out.values = out.fit.theta;
  out.sd = out.fit.covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
  free_inner_numbers(search, t, out);
  const Eigen::MatrixXd robust =
      robust_covariance(t, explained, NoiseModel(t.layout, out.fit.leftover), out.fit.walk_q);
  if (robust.size() > 0) out.sd = out.sd.cwiseMax(robust.diagonal().cwiseMax(0.0).cwiseSqrt());
  out.sd *= estimated_colour(t, explained);
  for (auto& numbers : out.inner_sd)
    for (auto& [name, sd] : numbers) sd *= estimated_colour(t, explained);
  hold_what_is_not_told(search, out);
  for (std::size_t i = 0; i < search.found.size(); ++i)
    if (search.found[i].timing.size())
      out.values.segment(first_column(search, i), search.found[i].timing.size()) += search.found[i].timing;
  return out;
}

Parameter number_of(const Finished& finished, Eigen::Index column, std::string name, std::string unit) {
  const double v = finished.values[column], half = 1.96 * finished.sd[column];
  return {std::move(name), v, {v - half, v + half}, std::move(unit)};
}

double chi_square_tail(double x, double k) {
  if (x <= 0) return 1.0;
  // Wilson and Hilferty's cube root is normal to better than one percent of the exponent for all k used here.
  const double z = (std::cbrt(x / k) - (1.0 - 2.0 / (9.0 * k))) / std::sqrt(2.0 / (9.0 * k));
  return std::max(0.5 * std::erfc(z / std::sqrt(2.0)), 1e-300);
}

bool is_white(const Series& x, const Layout& layout) {
  const Eigen::ArrayXd v = x.array() * layout.counts;
  const double n = layout.used(), power = v.square().sum();
  if (n < 10.0 * kWhitenessLags || power <= 0) return true;
  double q = 0.0;
  for (int lag = 1; lag <= kWhitenessLags; ++lag) {
    const double rho = (v.head(v.size() - lag) * v.tail(v.size() - lag)).sum() / power;
    q += rho * rho / (n - lag);
  }
  return n * (n + 2.0) * q < kChiSquare20_999;
}

}  // namespace stillpoint::diag
