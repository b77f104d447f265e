#include "diagnosis/reference/surplus.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "diagnosis/finding_effect.h"
#include "diagnosis/reference/given_effects.h"

namespace stillpoint::diag {
namespace {

constexpr double kClearDeviations = 5.0;  // of a share from 1; effects that are not in the simulation move it too
constexpr double kClearShare = 0.15;      // smaller differences are a number that was measured a little off
constexpr double kClearWalkNats = 7.0;    // a walk's rate against none
constexpr double kHalfNormal95 = 1.92;    // nats below the maximum at the ends of a 95 % interval
constexpr double kLeastOverNoise = 3e-3;  // of an effect's rms over one sample's noise; less moves nothing
constexpr Eigen::Index kMostSurplusRows = 16000;  // more are thinned by whole factors
constexpr std::array kWalkShares{0.0, 0.05, 0.1, 0.2, 0.35, 0.5, 0.7, 1.0, 1.4, 2.0, 3.0};

/// What one effect does to each sensor; empty where nothing.
using Deltas = std::array<Series3, kSensors>;

struct Share {
  double weighed = 0.0, weight = 0.0;  // sums over the sensors that an effect acts on
  [[nodiscard]] double value() const { return weighed / weight; }
  [[nodiscard]] double sd() const { return 1.0 / std::sqrt(weight); }
};

/// Effects that change what the reference predicts, or what a tracker lets through, have no size of their own.
bool has_a_size(const sim::EffectConfig& e) { return !e.id.starts_with("ref_") && e.id != "sys_tracker"; }

std::vector<Deltas> deltas_of(const Signals& bare, const Signals& thin, const std::vector<sim::EffectConfig>& given) {
  std::vector<Deltas> out(given.size());
  Signals alone = bare;
  const Eigen::Index factor = bare.n / thin.n;
  for (std::size_t i = 0; i < given.size(); ++i) {
    if (!has_a_size(given[i]) || !subtract_effects(alone, {given[i]}).empty()) continue;
    const Signals thinner = factor > 1 ? thinned(alone, factor) : Signals{};
    const Signals& without = factor > 1 ? thinner : alone;
    for (const Sensor k : {kAcc, kGyr, kMag}) {
      if (!bare.compared(k)) continue;
      Series3 delta = thin.residual[k] - without.residual[k];
      const double rms = std::sqrt(delta.squaredNorm() / static_cast<double>(3 * thin.n));
      if (rms > kLeastOverNoise * bare.noise_sd[k]) out[i][k] = std::move(delta);
    }
    alone.residual = bare.residual;
  }
  return out;
}

/// Adds what one sensor says of the shares.
void weigh(const Signals& bare, Sensor k, const std::vector<Deltas>& deltas, std::vector<Share>& shares) {
  Target t = make_target(bare, k);
  t.walk = walk_basis(bare);
  Columns columns;
  std::vector<std::size_t> of;
  for (std::size_t i = 0; i < deltas.size(); ++i)
    if (deltas[i][k].rows() > 0) columns.push_back({-1, deltas[i][k]}), of.push_back(i);
  if (columns.empty()) return;
  const Fit fit = fit_profile(t, columns);
  const Eigen::MatrixXd robust = robust_covariance(t, columns, NoiseModel(t.layout, fit.leftover), fit.walk_q);
  for (std::size_t j = 0; j < of.size(); ++j) {
    const auto at = static_cast<Eigen::Index>(j);
    const double variance = std::max(fit.covariance(at, at), robust.size() > 0 ? robust(at, at) : 0.0);
    if (!(variance > 0)) continue;
    shares[of[j]].weight += 1.0 / variance, shares[of[j]].weighed += fit.theta[at] / variance;
  }
}

/// Log-likelihood with walks of these rates, the noise estimated beside them.
double likelihood_at(const Target& t, const Columns& columns, const std::array<double, 3>& q) {
  constexpr int kRounds = 3;
  Target white = t;
  white.layout.order = 0;
  Fit fit = fit_with(white, columns, NoiseModel(white.layout, white.residual), q);
  for (int round = 0; round < kRounds; ++round) fit = fit_with(t, columns, NoiseModel(t.layout, fit.leftover), q);
  return fit.log_likelihood;
}

/// Rates of the walk that the simulation gives one sensor, a unit per sqrt(s).
std::array<double, 3> walk_of_simulation(const SensorSearch& search, const Signals& s,
                                         const std::vector<sim::EffectConfig>& given, const std::string& id) {
  std::array<double, 3> q{};
  q.fill(std::pow(s.triad[search.sensor].random_walk_per_sqrts, 2));
  for (const auto& e : given) {
    if (e.id != id || e.parameters.empty()) continue;
    const std::vector<double>& v = e.parameters.begin()->second;
    for (std::size_t a = 0; a < 3 && !v.empty(); ++a) q[a] += std::pow(v[v.size() == 3 ? a : 0], 2);
  }
  for (double& x : q) x = std::sqrt(x);
  return q;
}

/// The finding that tells this effect anew, as it looks behind an estimator on board; null where there is none.
Finding* behind_tracker(const std::string& id, std::vector<Finding>& findings) {
  const auto has_tracker = [](const Parameter& p) { return p.name == kTrackerShape; };
  const auto at = std::find_if(findings.begin(), findings.end(), [&](const Finding& f) {
    return f.effect == id && std::any_of(f.parameters.begin(), f.parameters.end(), has_tracker);
  });
  return at == findings.end() ? nullptr : &*at;
}

/// The simulation has the effect: what it lacks is the estimator.
void leave_the_tracker(Finding& f) {
  f.effect = "sys_tracker";
  f.equation = "u = y - b, db/dt = (y - b) / tau at rest";
  f.driver = "pattern of rests, and what drifts between them";
  std::erase_if(f.parameters, [](const Parameter& p) { return p.name != kTrackerShape; });
  f.parameters.front().name = "tau";
}

}  // namespace

std::vector<sim::EffectConfig> without_surplus(const Signals& bare, const std::vector<sim::EffectConfig>& given,
                                               Answer& answer) {
  if (given.empty()) return {};
  const Eigen::Index factor = std::max<Eigen::Index>(1, bare.n / kMostSurplusRows);
  const Signals thin = factor > 1 ? thinned(bare, factor) : bare;
  const std::vector<Deltas> deltas = deltas_of(bare, thin, given);
  std::vector<Share> shares(given.size());
  for (const Sensor k : {kAcc, kGyr, kMag})
    if (thin.present[k] && thin.residual[k].rows() > 0) weigh(thin, k, deltas, shares);
  std::vector<sim::EffectConfig> kept;
  for (std::size_t i = 0; i < given.size(); ++i) {
    const double off = shares[i].weight > 0 ? std::abs(shares[i].value() - 1.0) : 0.0;
    if (off < kClearShare || off < kClearDeviations * shares[i].sd()) {
      kept.push_back(given[i]);
      continue;
    }
    const double half = 1.96 * shares[i].sd(), share = shares[i].value();
    answer.diagnosis.surplus.push_back({given[i].id, 1.0, share, {share - half, share + half}});
    answer.surplus.push_back(given[i].id);
  }
  return kept;
}

void keep_what_was_right(const std::vector<sim::EffectConfig>& given, Answer& answer) {
  for (const auto& e : given) {
    Finding* const hidden = behind_tracker(e.id, answer.diagnosis.findings);
    const auto found = std::find_if(answer.effects.begin(), answer.effects.end(), [&](const auto& f) {
      return hidden != nullptr ? f.id == e.id : same_numbers(e, f);
    });
    if (found == answer.effects.end() || std::erase(answer.surplus, e.id) == 0) continue;
    answer.effects.erase(found);
    std::erase_if(answer.diagnosis.surplus, [&e](const Surplus& x) { return x.effect == e.id; });
    if (hidden != nullptr && !contains(given, "sys_tracker")) leave_the_tracker(*hidden);
    std::erase_if(answer.diagnosis.findings, [&e](const Finding& f) { return f.effect == e.id; });
  }
}

void report_surplus_walk(const SensorSearch& search, const Signals& s, const std::vector<sim::EffectConfig>& given,
                         Answer& answer) {
  const std::string id = std::string(kSensorName[search.sensor]) + "_drift";
  const std::array<double, 3> q = walk_of_simulation(search, s, given, id);
  if (*std::max_element(q.begin(), q.end()) <= 0) return;
  const Target t = search.beside_walk();
  const Columns explained = search.explained();
  std::array<double, kWalkShares.size()> likelihood{};
  for (std::size_t i = 0; i < kWalkShares.size(); ++i)
    likelihood[i] = likelihood_at(t, explained, {kWalkShares[i] * q[0], kWalkShares[i] * q[1], kWalkShares[i] * q[2]});
  const auto best = std::max_element(likelihood.begin(), likelihood.end());
  const auto as_given =
      static_cast<std::size_t>(std::find(kWalkShares.begin(), kWalkShares.end(), 1.0) - kWalkShares.begin());
  if (likelihood[0] - likelihood[as_given] < kClearWalkNats) return;
  double low = HUGE_VAL, high = 0.0;
  for (std::size_t i = 0; i < kWalkShares.size(); ++i)
    if (likelihood[i] > *best - kHalfNormal95) low = std::min(low, kWalkShares[i]), high = kWalkShares[i];
  const double share = kWalkShares[static_cast<std::size_t>(best - likelihood.begin())];
  answer.diagnosis.surplus.push_back({id, 1.0, share, {low, high}});
  answer.surplus.push_back(id);
  if (s.triad[search.sensor].random_walk_per_sqrts <= 0) return;
  auto& numbers = answer.numbers[search.sensor];
  if (!numbers) numbers = s.given[search.sensor];
  numbers->random_walk_per_sqrts = 0.0;
  answer.diagnosis.notices.push_back(fmt::format(
      "{}: random_walk_per_sqrts of the simulation is not in the recording; it is 0 in the improved simulation",
      kSensorName[search.sensor]));
}

}  // namespace stillpoint::diag
