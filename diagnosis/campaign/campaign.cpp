#include "diagnosis/campaign/campaign.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "diagnosis/answer_words.h"
#include "diagnosis/discovery/law_words.h"
#include "diagnosis/finding_effect.h"
#include "diagnosis/forensics/forensics.h"
#include "diagnosis/validation.h"
#include "simulation/law_effect.h"

namespace stillpoint::diag {
namespace {

constexpr double kByChance = 0.005;  ///< that any number of an effect is called apart
constexpr double kSeen = 3.0;

double sd_of(const Parameter& p) { return (p.ci95[1] - p.ci95[0]) / (2.0 * 1.96); }

std::string sensor_of(const Finding& f) { return f.channels.empty() ? "" : f.channels.front().substr(0, 3); }

/// The entry that an answer wrote for its finding; none where it has no law.
const sim::EffectConfig* entry_of(const Answer& answer, const Finding& f) {
  const auto same = std::find_if(answer.effects.begin(), answer.effects.end(),
                                 [&f](const sim::EffectConfig& e) { return is_entry_of(e, f) && !sim::is_table(e); });
  return same == answer.effects.end() ? nullptr : &*same;
}

/// What happens at a time is an event of one recording.
bool is_event(const sim::EffectConfig& e) {
  return e.window_s || e.parameters.count("t0_s") > 0 || e.id.find("step(t,") != std::string::npos;
}

/// The same parameter in a part's finding of the same effect; null where it has none.
const Parameter* find_parameter(const Finding& f, const std::string& name) {
  const auto same =
      std::find_if(f.parameters.begin(), f.parameters.end(), [&](const Parameter& p) { return p.name == name; });
  return same == f.parameters.end() ? nullptr : &*same;
}

struct Weighed {
  double sum = 0.0, weight = 0.0;
  /// `sign` -1 takes it out again.
  void add(const Parameter& p, double sign = 1.0) {
    const double w = sign / std::max(sd_of(p) * sd_of(p), 1e-300);
    sum += w * p.value;
    weight += w;
  }
  [[nodiscard]] double mean() const { return sum / weight; }
  [[nodiscard]] double sd() const { return 1.0 / std::sqrt(weight); }
};

/// Pools the findings of one effect; `each` belongs to `effect.found_in`.
void pool(const std::vector<const Finding*>& each, SharedEffect& effect) {
  // The normal distribution's bound exp(-z^2 / 2), shared among all numbers that are compared.
  const auto compared = static_cast<double>(each.size() * effect.pooled.parameters.size());
  const double apart_sd = std::sqrt(2.0 * std::log(compared / kByChance));
  for (Parameter& p : effect.pooled.parameters) {
    Weighed all;
    std::vector<std::pair<std::size_t, const Parameter*>> seen;
    for (std::size_t i = 0; i < each.size(); ++i)
      if (const Parameter* q = find_parameter(*each[i], p.name); q && sd_of(*q) > 0.0 && std::isfinite(q->value)) {
        all.add(*q);
        seen.emplace_back(effect.found_in[i], q);
      }
    double chi2 = 0.0;
    for (const auto& [part, q] : seen) {
      chi2 += std::pow((q->value - all.mean()) / sd_of(*q), 2);
      Weighed others = all;
      others.add(*q, -1.0);
      const bool apart =
          seen.size() > 1 && std::abs(q->value - others.mean()) > apart_sd * std::hypot(sd_of(*q), others.sd());
      if (apart && std::find(effect.apart.begin(), effect.apart.end(), part) == effect.apart.end())
        effect.apart.push_back(part);
    }
    effect.chi2.push_back(chi2);
    if (seen.empty()) continue;
    const double freedom = std::max(1.0, static_cast<double>(seen.size()) - 1.0);
    const double half = 1.96 * all.sd() * std::sqrt(std::max(1.0, chi2 / freedom));
    p.value = all.mean();
    p.ci95 = {p.value - half, p.value + half};
  }
}

/// The entry with the pooled numbers.
std::optional<sim::EffectConfig> pooled_entry(const Finding& pooled, const sim::EffectConfig& of_one) {
  if (!is_unknown(pooled)) return effect_of(pooled);
  sim::EffectConfig e = of_one;
  auto& numbers = e.parameters.begin()->second;
  if (e.parameters.size() != 1 || pooled.parameters.size() < numbers.size()) return e;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const Parameter& p = pooled.parameters[i];
    numbers[i] = std::abs(p.value) > kSeen * sd_of(p) ? p.value : 0.0;
  }
  return e;
}

std::vector<Validation> removed_by(const CampaignPart& part, const sim::SimulationConfig& simulation,
                                   const std::vector<SharedEffect>& effects) {
  sim::SimulationConfig improved = simulation;
  for (const SharedEffect& e : effects)
    if (e.entry) improved.effects.push_back(*e.entry);
  return validate(part.file, *part.recording, simulation, improved);
}

}  // namespace

std::vector<SharedEffect> shared_effects(const std::vector<CampaignPart>& parts, std::optional<std::size_t> leave_out) {
  struct Seen {
    SharedEffect effect;
    std::vector<const Finding*> each;
    const sim::EffectConfig* entry;
  };
  std::vector<Seen> all;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (i == leave_out) continue;
    for (const Finding& f : parts[i].answer.diagnosis.findings) {
      const sim::EffectConfig* entry = entry_of(parts[i].answer, f);
      if (entry == nullptr || is_event(*entry)) continue;
      auto same = std::find_if(all.begin(), all.end(), [&](const Seen& s) {
        return s.effect.pooled.effect == f.effect && sensor_of(s.effect.pooled) == sensor_of(f);
      });
      if (same == all.end()) same = all.insert(all.end(), Seen{{f, {}, {}, {}, {}, false, false}, {}, entry});
      if (f.held_out.gain_nats > same->effect.pooled.held_out.gain_nats) same->effect.pooled = f, same->entry = entry;
      same->effect.found_in.push_back(i);
      same->each.push_back(&f);
    }
  }
  std::vector<SharedEffect> out;
  for (Seen& s : all) {
    pool(s.each, s.effect);
    s.effect.entry = pooled_entry(s.effect.pooled, *s.entry);
    s.effect.confirmed = s.effect.found_in.size() > 1;
    out.push_back(std::move(s.effect));
  }
  std::stable_sort(out.begin(), out.end(),
                   [](const auto& a, const auto& b) { return a.found_in.size() > b.found_in.size(); });
  return out;
}

Campaign join(const std::vector<CampaignPart>& parts, const sim::SimulationConfig& simulation) {
  Campaign c;
  c.effects = shared_effects(parts);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    for (Validation& v : removed_by(parts[i], simulation, shared_effects(parts, i)))
      c.by_others.push_back(std::move(v));
    for (SharedEffect& e : c.effects) {
      if (!e.entry || std::find(e.found_in.begin(), e.found_in.end(), i) != e.found_in.end()) continue;
      for (const Validation& v : removed_by(parts[i], simulation, {e})) {
        if (!(is_unknown(e.pooled) ? v.sensor == sensor_of(e.pooled) : acts_on(e.pooled.effect, v.sensor))) continue;
        e.contradicted |= v.ci95[1] < 0.0;
        e.confirmed |= v.ci95[0] > 0.0;
      }
    }
    for (const Finding& f : parts[i].answer.diagnosis.findings) {
      const sim::EffectConfig* entry = entry_of(parts[i].answer, f);
      if (entry == nullptr || is_event(*entry))
        c.own.push_back(fmt::format("{}: {} in {}", parts[i].file, f.effect, fmt::join(f.channels, ", ")));
    }
  }
  return c;
}

sim::SimulationConfig improved_by(const Campaign& campaign, sim::SimulationConfig simulation) {
  for (const SharedEffect& e : campaign.effects)
    if (e.entry && e.confirmed && !e.contradicted) simulation.effects.push_back(*e.entry);
  return simulation;
}

}  // namespace stillpoint::diag
