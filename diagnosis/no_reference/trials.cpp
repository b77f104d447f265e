#include "diagnosis/no_reference/trials.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "diagnosis/finding_effect.h"

namespace stillpoint::diag::detail {
namespace {

constexpr double kDispersion = 1.5;  // mean square of whitened residuals above which something is left unexplained
constexpr std::size_t kMostTried = 8;
constexpr double kNear_nats = 10.0, kNearShare = 0.7;  // of the best: what the second order may still turn round
constexpr double kHopeless = 2.0;  // times the misfit that another law leaves; as is more than there was without any

/// The candidate beside the laws of the trial's own model.
Trial prepared(const SelfConsistency& model, const sim::SimulationConfig& simulation,
               const std::vector<std::string>& without, const Candidate& candidate) {
  Trial t{std::make_unique<SelfConsistency>(model), {}, candidate};
  t.laws = open_laws(*t.model, simulation, without);
  t.candidate.law = &*std::find_if(t.laws.begin(), t.laws.end(),
                                   [&](const WitnessedLaw& law) { return law.id == candidate.law->id; });
  return t;
}

void score(const SelfConsistency& before, Trial& t) {
  const double better = before.misfit_nats() - t.model->misfit_nats() - t.candidate.charges;
  t.candidate.score = std::isfinite(better) && plausible(t.candidate) ? better : -HUGE_VAL;
}

/// What was settled around the law is bent by it: where much is left, from the simulation's numbers, or else as it is.
Trial taken_out(const SelfConsistency& model, const sim::SimulationConfig& simulation,
                const std::vector<std::string>& without, const Candidate& candidate, double hopeless_nats) {
  Trial best;
  for (const bool anew : {true, false}) {
    if (anew && !bent(model)) continue;
    Trial t = prepared(model, simulation, without, candidate);
    if (anew) t.model->start_anew();
    relinearise(*t.model, t.candidate, hopeless_nats);
    score(model, t);
    if (!best.model || t.candidate.score > best.candidate.score) best = std::move(t);
    if (best.candidate.score > kAbstain_nats) break;
  }
  return best;
}

/// From where another law has led.
Trial instead_of(const Trial& other, const SelfConsistency& model, const sim::SimulationConfig& simulation,
                 const std::vector<std::string>& without, const Candidate& candidate) {
  Trial t = prepared(*other.model, simulation, without, candidate);
  const auto taken = other.candidate.law->columns(other.candidate.grid_value);
  auto columns = t.candidate.law->columns(t.candidate.grid_value);
  t.candidate.applied = t.model->instead_of(taken, other.candidate.applied, columns);
  t.model->replace(taken, other.candidate.applied, columns, t.candidate.applied);
  t.candidate.fit = t.model->fit(columns, t.candidate.applied);
  relinearise(*t.model, t.candidate, HUGE_VAL, std::move(columns));
  score(model, t);
  return t;
}

/// Of laws as good as each other the one with fewer numbers: where it leaves as little, or where offsets that wander
/// leave nothing to choose.
bool better(Trial& one, Trial& other) {
  const std::size_t numbers = one.candidate.law->numbers(), of_other = other.candidate.law->numbers();
  if (numbers == of_other) return one.candidate.score > other.candidate.score;
  if (numbers > of_other) return !better(other, one);
  return one.candidate.score > other.candidate.score - kEquivalent_nats ||
         (one.candidate.score > kAbstain_nats &&
          one.agreed().nats > std::max(kAbstain_nats, other.agreed().nats - kEquivalent_nats));
}

}  // namespace

const Agreement& Trial::agreed() {
  if (!known) known = agreement(*model, candidate);
  return *known;
}

bool bent(const SelfConsistency& model) { return model.dispersion() > kDispersion; }

std::vector<WitnessedLaw> open_laws(const SelfConsistency& model, const sim::SimulationConfig& simulation,
                                    const std::vector<std::string>& without) {
  auto laws = witnessed_laws(model, simulation);
  std::erase_if(
      laws, [&](const WitnessedLaw& law) { return contains(simulation.effects, law.id) || contains(without, law.id); });
  return laws;
}

Trial best_of(const SelfConsistency& model, const sim::SimulationConfig& simulation,
              const std::vector<std::string>& without, std::vector<Candidate>& ranking) {
  double near = -HUGE_VAL;  // of the first that is a number at all
  Trial best;
  for (std::size_t i = 0; i < std::min(kMostTried, ranking.size()); ++i) {
    Candidate& c = ranking[i];
    const double untried = c.score;
    if (untried < kAbstain_nats || (!bent(model) && untried < near)) break;
    const double hopeless =
        std::min(model.misfit_nats(), best.model ? kHopeless * best.model->misfit_nats() : HUGE_VAL);
    Trial t = taken_out(model, simulation, without, c, hopeless);
    c.score = t.candidate.score;
    if (!std::isfinite(c.score)) continue;
    if (!best.model) near = std::min(kNearShare * untried, untried - kNear_nats);
    if (!best.model || better(t, best)) best = std::move(t);
  }
  if (!best.model) return {};
  for (std::size_t i = 0; bent(model) && i < std::min(kMostTried, ranking.size()); ++i) {
    if (!std::isfinite(ranking[i].score) || ranking[i].law->numbers() >= best.candidate.law->numbers()) continue;
    Trial t = instead_of(best, model, simulation, without, ranking[i]);
    if (better(t, best)) best = std::move(t);
  }
  std::sort(ranking.begin(), ranking.end(), [](const auto& a, const auto& b) { return a.score > b.score; });
  if (best.candidate.score < kAbstain_nats) return {};
  return best;
}

std::unique_ptr<SelfConsistency> put_back(const Trial& trial) {
  auto plain = std::make_unique<SelfConsistency>(*trial.model);
  plain->replace(trial.candidate.law->columns(trial.candidate.grid_value), trial.candidate.applied, {}, {});
  return plain;
}

}  // namespace stillpoint::diag::detail
