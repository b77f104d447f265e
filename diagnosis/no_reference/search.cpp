#include "diagnosis/no_reference/search.h"

#include <algorithm>

#include "diagnosis/certainty.h"
#include "diagnosis/usual_size.h"
#include "simulation/effect_catalogue.h"

namespace stillpoint::diag::detail {
namespace {

constexpr double kLargestTau_s = 0.1;
constexpr int kPassesOfGiven = 4;
constexpr double kFlicker = 4.0;  // of the mean over half a second: parts wander by twice it from rest to rest
constexpr int kHalvings = 12;     // of a grid's step

/// For the coefficients as with a reference (docs/decisions/043), and the logarithm of the number of places and names
/// searched.
double charge(std::size_t coefficients, std::size_t grid, std::size_t names) {
  return kNatsPerCoefficient * static_cast<double>(coefficients) +
         std::log(static_cast<double>(std::max<std::size_t>(grid, 1))) + std::log(static_cast<double>(names));
}

Candidate at(const SelfConsistency& model, const WitnessedLaw& law, double g) {
  Candidate c;
  c.law = &law;
  c.grid_value = g;
  c.fit = model.fit(law.columns(g));
  return c;
}

/// Best of the grid, then halvings around it; the interval is where the gain has fallen by 1.92 nats.
Candidate over_grid(const SelfConsistency& model, const WitnessedLaw& law) {
  Candidate best;
  std::size_t best_at = 0;
  for (std::size_t i = 0; i < law.grid.size(); ++i) {
    Candidate c = at(model, law, law.grid[i]);
    if (best.law == nullptr || c.fit.gain_nats > best.fit.gain_nats) best = std::move(c), best_at = i;
  }
  if (best.law == nullptr) return at(model, law, 0.0);
  double left = law.grid[best_at > 0 ? best_at - 1 : 0], right = law.grid[std::min(best_at + 1, law.grid.size() - 1)];
  if (best.fit.gain_nats < kAbstain_nats) {
    best.grid_ci95 = {left, right};
    return best;
  }
  // A step is between two rows; so near to it that a strong one leaves no row on the wrong side.
  const double least = law.grid_name == "t0" ? 0.25 * model.recording().median_step_s()
                                             : 1e-3 * std::max(1.0, std::abs(best.grid_value));
  double low = left, high = right;
  for (int halving = 0; halving < kHalvings && right - left > least; ++halving) {
    for (const double g : {0.5 * (left + best.grid_value), 0.5 * (best.grid_value + right)}) {
      Candidate c = at(model, law, g);
      if (c.fit.gain_nats < best.fit.gain_nats - 1.92)
        (g < best.grid_value ? low : high) = g;
      else if (c.fit.gain_nats > best.fit.gain_nats)
        best = std::move(c);
    }
    left = std::max(left, best.grid_value - 0.5 * (right - left) * 0.5 - least);
    right = std::min(right, best.grid_value + 0.5 * (right - left) * 0.5 + least);
  }
  best.grid_ci95 = {std::min(low, best.grid_value), std::max(high, best.grid_value)};
  return best;
}

/// The numbers of an entry in the order of the law's coefficients; empty when they do not fit it.
Eigen::VectorXd values_for(const WitnessedLaw& law, const sim::EffectConfig& e) {
  std::vector<double> values;
  const auto& parameters = sim::find_effect(e.id)->parameters;
  for (const bool required : {false, true})  // the linear part of a quadratic stands first, and may be left out
    for (const auto& p : parameters) {
      if (p.required != required || p.key == "t0_s" || p.symbol == law.grid_name) continue;
      const auto given = e.parameters.find(p.key);
      std::vector<double> v = given == e.parameters.end()
                                  ? std::vector<double>(static_cast<std::size_t>(p.count), p.fallback)
                                  : given->second;
      if (v.size() == 1 && p.count == 3) v.resize(3, v[0]);
      for (std::size_t i = 0; i < v.size() && !e.axes.empty() && v.size() == 3; ++i)
        if (std::find(e.axes.begin(), e.axes.end(), static_cast<int>(i)) == e.axes.end()) v[i] = 0.0;
      values.insert(values.end(), v.begin(), v.end());
    }
  if (values.size() > law.names.size())
    values.erase(values.begin(), values.end() - static_cast<long>(law.names.size()));
  if (values.size() != law.names.size()) return {};
  return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<long>(values.size()));
}

}  // namespace

bool plausible(const Candidate& c) {
  const auto& id = c.law->id;
  const double first = c.fit.value[0];
  if (id == "gyr_delay" || id == "mag_delay") return first > 0 && first < kLargestTau_s;
  if (id == "gyr_earth") return first > 0.2 && first < 5.0;
  if (id == "mag_soft_step") return c.fit.value.cwiseAbs().maxCoeff() < 0.5;  // iron does not turn the field about
  return may_be_of_a_part(*sim::find_effect(id), c.law->names, c.fit.value, c.fit.sd);
}

Agreement agreement(const SelfConsistency& model, const Candidate& c) {
  const auto columns = c.law->columns(c.grid_value);
  const Eigen::VectorXd left = c.applied.size() > 0 ? (c.fit.value - c.applied).eval() : c.fit.value;
  const Eigen::MatrixXd between = model.covariance_between_stretches(columns, left);
  const Eigen::MatrixXd both = c.fit.covariance + between;
  const BesideWander wander = model.beside_wander(columns, c.applied);
  return {std::min(0.5 * c.fit.value.dot(both.ldlt().solve(c.fit.value)), wander.gain_nats - c.charges),
          c.fit.sd.cwiseMax(between.diagonal().cwiseSqrt()).cwiseMax(wander.sd)};
}

std::vector<Candidate> rank(const SelfConsistency& model, const std::vector<WitnessedLaw>& laws) {
  std::vector<Candidate> all;
  for (const auto& law : laws) {
    Candidate best = law.grid.empty() ? at(model, law, 0.0) : over_grid(model, law);
    best.charges = charge(law.names.size(), law.grid.size(), laws.size());
    best.score = best.fit.gain_nats - best.charges;
    if (plausible(best)) all.push_back(std::move(best));
  }
  std::sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.score > b.score; });
  return all;
}

void relinearise(SelfConsistency& model, Candidate& c, double hopeless_nats, std::vector<LawColumn> taken) {
  constexpr int kMostPasses = 8;  // each time all of it anew: the driver (corrected force or rate) moves too
  constexpr int kFairTrial = 2;   // passes; by then what bends the attitude back has done most of it
  constexpr double kLeastStep = 1.0 / 16.0;
  if (taken.empty()) c.applied = Eigen::VectorXd::Zero(c.fit.value.size());
  for (int pass = 0; pass < kMostPasses; ++pass) {
    const Eigen::VectorXd from = c.applied, nuisances = model.nuisances();
    const double misfit = model.misfit_nats();
    bool nearer = false;
    for (double step = 1.0; step >= kLeastStep && !nearer; step *= 0.5) {  // a whole one may bend the attitude too far
      if (step < 1.0) model.start_from(nuisances);
      std::vector<LawColumn> columns = c.law->columns(c.grid_value);
      const Eigen::VectorXd value = from + step * (c.fit.value - from);
      model.replace(taken, c.applied, columns, value);
      taken = std::move(columns);
      c.applied = value;
      nearer = model.misfit_nats() < misfit + kAbstain_nats;
    }
    if (!nearer) break;
    c.fit = model.fit(c.law->columns(c.grid_value), c.applied);
    if ((c.fit.value - c.applied).cwiseAbs().cwiseQuotient(c.fit.sd).maxCoeff() < 0.1) break;
    if (pass + 1 >= kFairTrial && model.misfit_nats() > hopeless_nats) break;
  }
}

void take_out_given(SelfConsistency& model, const std::vector<WitnessedLaw>& laws,
                    const std::vector<sim::EffectConfig>& given) {
  for (const auto& e : given)
    for (const auto& law : laws) {
      if (law.id != e.id) continue;
      const auto shape = e.parameters.find(law.grid_name + "_s");
      const double t0 = law.grid_name == "t0" ? model.recording().t_s(0) : 0.0;
      const Eigen::VectorXd value = values_for(law, e);
      if (value.size() == 0 || (!law.grid_name.empty() && shape == e.parameters.end())) continue;
      const double g = law.grid_name.empty() ? 0.0 : t0 + shape->second.front();
      std::vector<LawColumn> taken;
      Eigen::VectorXd taken_value;
      for (int pass = 0; pass < kPassesOfGiven; ++pass) {  // the driver moves with the calibration that follows
        auto columns = law.columns(g);
        // What was settled with the effect still in the readings is bent by it: from the simulation's numbers again.
        model.start_from(Eigen::VectorXd::Zero(model.nuisances().size()));
        model.replace(taken, taken_value, columns, value);
        taken = std::move(columns);
        taken_value = value;
      }
    }
}

/// Its many coefficients are drawn from one law (a walk), so it is charged for the
/// information in them, a third of the usual.
double drift_score(const SelfConsistency& model, Sensor sensor) {
  const auto columns = free_offsets(model, sensor);
  if (columns.empty()) return -HUGE_VAL;
  const LawFit fit = model.fit(columns);
  const double wanders = fit.value.norm() / std::sqrt(static_cast<double>(fit.value.size()));
  if (sensor == kGyr && wanders < kFlicker * model.cell_radps()) return -HUGE_VAL;
  return fit.gain_nats - 1.5 * static_cast<double>(columns.size()) - 4.0;
}

}  // namespace stillpoint::diag::detail
