#include "diagnosis/discovery/discover.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "diagnosis/discovery/drivers.h"
#include "diagnosis/discovery/law_search.h"
#include "diagnosis/discovery/law_words.h"
#include "diagnosis/reference/evidence.h"
#include "diagnosis/reference/judge.h"
#include "diagnosis/reference/lines.h"
#include "diagnosis/reference/plausible.h"
#include "diagnosis/reference/sensors_at_once.h"
#include "diagnosis/reference/separable.h"
#include "diagnosis/reference/wandering_reference.h"

namespace stillpoint::diag {
namespace {

constexpr std::size_t kMostTerms = 3;
// Nats before a law is spoken of: where the engine found nothing unknown, only a drift, or something without a name.
// Clean recordings of field_open reach 74 in the scan without a drift, and 43 beside one.
constexpr double kSpeaks = 300.0, kSpeaksOverDrift = 100.0, kSpeaksOfUnknown = 20.0;
// The same, where it surely removes half of what is removable where it was not fitted: 40 clean recordings of a second
// generator reach 21 beside exact references, 44 reach 52 beside cameras.
constexpr double kSpeaksSurely = 50.0, kSpeaksSurelyByCamera = 80.0;
constexpr double kWorthLooking = 0.5;                    // of what is asked for, by one idea on few rows
constexpr double kRemainder = 0.05;                      // of a large effect's gain is what its model leaves
constexpr double kFurther = 60.0, kFurtherShare = 0.03;  // of the first term's gain
constexpr double kOfTheBest = 0.5;                       // of its net gain: what follows it is another law
constexpr double kMostOpen = 0.4;                        // deviation of all numbers of a law over their size
constexpr double kLeaves = 1.02;                         // of the rms before, where it is noise that a law leaves
// Of laws that fall short of the best one by no more than this share of its gain, or so many nats, the one with fewer
// numbers: what six more of them gain in so little is the misfit of this motion.
constexpr double kAlikeShare = 0.1, kAlikeLeast = 6.0, kAlikeMost = 40.0;
// Nats over the engine's own answer, lengths taken off.
constexpr double kBetter = 3.0, kBetterThanNames = 30.0, kBetterThanWindows = 50.0;

bool is_clock(const Found& f) { return f.kind == Kind::kTiming || f.kind == Kind::kConfiguration; }

/// The catalogue's steps have a beginning by their nature.
bool is_named_step(const Found& f) { return f.kind == Kind::kNamed && f.id.ends_with("_step"); }

/// What the engine could not name: products, and pieces of something that comes and goes.
bool is_open(const Found& f) {
  return f.kind == Kind::kUnknown || (f.window.local && !is_clock(f) && !is_named_step(f));
}

double length_of(const SensorSearch& search, double bits) {
  double charges = kNatsABit * bits;
  for (const Found& f : search.found) charges += charge(f.columns.size(), f.window);
  return charges;
}

double worth(const SensorSearch& search, double bits) {
  const double with = fit_profile(search.beside_walk(), search.explained()).log_likelihood - 8.0;
  const double without = fit_profile(search.target, search.explained()).log_likelihood;
  return std::max(with, without) - length_of(search, bits);
}

SensorSearch without_some(const SensorSearch& search, bool (*drop)(const Found&)) {
  SensorSearch out = search;
  for (std::size_t i = out.found.size(); i-- > 0;)
    if (drop(out.found[i])) take_out(out, i);
  return out;
}

double gain_of(const SensorSearch& search, bool (*counts)(const Found&)) {
  double gain = 0.0;
  for (const Found& f : search.found)
    if (counts(f)) gain += f.gain_nats;
  return gain;
}

/// It lasts and is no law, so that no simulation can have it: "h(I)".
bool is_no_law(const Found& f) { return f.kind == Kind::kUnknown && !f.window.local && !law_tree(f.id); }

bool is_name(const Found& f) { return !is_open(f) && !is_clock(f); }
bool is_named_for_a_while(const Found& f) { return f.kind == Kind::kNamed && is_open(f); }

struct Discovered {
  SensorSearch search;
  double bits = 0.0, gain = 0.0;
};

/// Whether its numbers are known as a whole. A factor that hardly varies here - the field, gravity in one attitude -
/// leaves a matrix open that fits all the same; in every other attitude it would be another law.
bool is_determined(const Fit& fit, const Found& law) {
  const auto count = static_cast<Eigen::Index>(law.columns.size());
  const double variance = fit.covariance.diagonal().tail(count).cwiseMax(0.0).sum();
  return std::sqrt(variance) < kMostOpen * fit.theta.tail(count).norm();
}

/// What it leaves out of its fit is larger with it than without: a wandering offset, or a bias and matrix that this
/// motion hardly tells from it, took back what it does.
bool leaves_more(const HeldOut& h) { return !predicts(h) || h.rms_after > kLeaves * h.rms_before; }

/// What would not be stated must not stand in the place of what would: how it fares where it was not fitted, nothing
/// where it may not be stated. `before`: the fit without it.
std::optional<HeldOut> as_stated(const Signals& s, const SensorSearch& search, const Found& law, const Fit& before,
                                 const Fit& beside) {
  if (!is_separable(s, search.sensor, law.columns) || !varies(search, law, beside)) return std::nullopt;
  if (!is_determined(beside, law) || moves_the_others(search, before, beside)) return std::nullopt;
  if (is_a_trace_of_the_cameras(s, search, law, beside)) return std::nullopt;
  const bool may_be_the_camera = search.sensor == kMag || as_small_as_wandering(s, search, law, beside);
  if (may_be_the_camera && !stands_beside_wandering(s, search, law)) return std::nullopt;
  SensorSearch with = search;
  with.found.push_back(law);
  HeldOut held_out = held_out_by_regime(with, {with.found.size() - 1});
  if (fails_elsewhere(held_out, law.id) || leaves_more(held_out)) return std::nullopt;
  return held_out;
}

/// The rate of the reading itself beside a delay or filter of it, alone or with a factor that changes nothing: the two
/// would share one cause, and undo each other.
bool is_a_delay_again(const SensorSearch& search, const std::vector<Term>& terms, const Term& t) {
  if (std::none_of(search.found.begin(), search.found.end(), [](const Found& f) { return f.kind == Kind::kTiming; }))
    return false;
  const std::string rate = fmt::format("d({})", own_vector(search.sensor));
  const std::string& text = t.idea.texts.front();
  return text == rate || (text.starts_with(rate + " * ") && std::any_of(terms.begin(), terms.end(), [&](const Term& o) {
                            return o.idea.texts.front() == rate && o.found.net_nats > t.found.net_nats - kAlikeLeast;
                          }));
}

/// By the noise model and by the scatter of the seconds.
double sure_gain(const SensorSearch& search, const Found& law, const Fit& beside) {
  return std::min(law.gain_nats, robust_nats(search, law, beside));
}

/// Of its factors the first ones alone, where they explain as much: one that hardly varies here, such as gravity at
/// rest, is nothing that was seen to matter.
const Term* without_idle_factors(const Signals& s, const SensorSearch& search, const std::vector<Term>& terms,
                                 const Term* chosen, const Fit& before) {
  const Term& whole = *chosen;
  for (const Term& t : terms) {
    const bool part =
        whole.found.id.starts_with(t.found.id + " * ") && t.found.columns.size() <= whole.found.columns.size();
    if (part && t.bits < chosen->bits && t.found.net_nats > whole.found.net_nats - kAlikeLeast &&
        as_stated(s, search, t.found, before, fit_beside(search, t.found)))
      chosen = &t;
  }
  return chosen;
}

/// Nats that a law has to gain: any, and one that surely predicts.
struct Least {
  double any, surely;
};

/// The best that gains enough and may be stated; of those that the recording hardly tells from it the one with the
/// fewest numbers, which is the surer one on another motion. nullptr: none.
const Term* choose(const Signals& s, const SensorSearch& search, const std::vector<Term>& terms, Least gain) {
  if (terms.empty()) return nullptr;
  const Term* chosen = nullptr;
  const Fit before = fit_profile(search.beside_walk(), search.explained());
  double least = kOfTheBest * terms.front().found.net_nats;
  for (const Term& t : terms) {
    if (t.found.net_nats < least) break;
    if (is_a_delay_again(search, terms, t)) continue;
    if (chosen && t.found.columns.size() >= chosen->found.columns.size()) continue;
    const Fit beside = fit_beside(search, t.found);
    const double sure = sure_gain(search, t.found, beside);
    if (sure < std::min(gain.any, gain.surely)) continue;
    const auto held_out = as_stated(s, search, t.found, before, beside);
    if (!held_out || (sure < gain.any && (!is_judged(*held_out) || is_unsure(*held_out)))) continue;
    if (!chosen) least = t.found.net_nats - std::clamp(kAlikeShare * t.found.gain_nats, kAlikeLeast, kAlikeMost);
    chosen = &t;
  }
  return chosen ? without_idle_factors(s, search, terms, chosen, before) : nullptr;
}

/// Terms one after another, as long as each pays for itself; the first may have to begin at an event.
std::optional<Discovered> terms_beside(const Signals& s, LawSearch& laws, SensorSearch base, Least least, bool event) {
  Discovered out{std::move(base), 0.0, 0.0};
  const std::size_t names = out.search.found.size();
  double first = 0.0;
  for (std::size_t round = 0; round < kMostTerms; ++round) {
    const std::vector<Term> terms = event && round == 0 ? laws.next_event(out.search) : laws.next(out.search);
    const double further = std::max(kFurther, kFurtherShare * first);
    const Term* chosen = choose(s, out.search, terms, round == 0 ? least : Least{further, further});
    if (!chosen) break;
    const Term& t = *chosen;
    SensorSearch with = out.search;
    for (Found& f : effects_of(t, with.sensor, laws.drivers())) {
      f.rivals.clear();
      for (const Term& r : terms) f.rivals.push_back({r.found.id, {}, r.found.gain_nats, r.found.net_nats});
      with.found.push_back(std::move(f));
    }
    if (round == 0) first = sure_gain(out.search, t.found, fit_beside(out.search, t.found));
    out.search = std::move(with);
    out.bits += t.bits;
    out.gain += t.found.gain_nats;
    if (!t.idea.points.empty()) break;  // a formula of the same driver and a table would cancel each other
  }
  if (first == 0.0) return std::nullopt;
  weigh_again(out.search, names);
  return out;
}

double speaks_surely(const Signals& s) { return s.exact_reference ? kSpeaksSurely : kSpeaksSurelyByCamera; }

/// What a law has to gain before it is spoken of, by what the engine ended with.
Least least_gain(const Signals& s, const SensorSearch& search, bool open, bool drifts) {
  if (open) return {kSpeaksOfUnknown, kSpeaksOfUnknown};
  const double remainder = kRemainder * search.first_gain;
  return {std::max(drifts ? kSpeaksOverDrift : kSpeaks, remainder), std::max(speaks_surely(s), remainder)};
}

/// Of the lines that were found, of one that is there but no line of one size - it swells with its driver -, and of one
/// that stands in the world.
std::vector<double> frequencies(const Signals& s, const SensorSearch& sensor) {
  std::vector<double> out;
  const auto add = [&out](const Found& f) {
    if (f.shape_unit == "Hz" && f.offset.size() == 0) out.push_back(f.shape);
  };
  for (const Found& f : sensor.found)
    if (f.id != kBodyVibration) add(f);
  const SensorSearch named = without_some(sensor, is_open);
  if (const auto line = out.empty() ? line_in(s, named) : std::nullopt; line && line->kind == Kind::kNamed) add(*line);
  if (sensor.sensor != kMag) return out;
  if (const auto f_hz = line_in_world(s, named)) out.push_back(*f_hz);
  return out;
}

void discover_in(const Signals& s, SensorSearch& sensor) {
  const auto any = [&](auto is) { return std::any_of(sensor.found.begin(), sensor.found.end(), is); };
  const bool open = any(is_open), drifts = !sensor.walk_is_given && Judge(sensor).walking();
  const std::vector<double> lines_hz = frequencies(s, sensor);
  LawSearch laws(s, sensor.sensor, lines_hz, sensor.moments_s);
  const bool named = any(is_name);
  const SensorSearch bare = without_some(sensor, [](const Found& f) { return !is_clock(f); });
  const double outdoes = gain_of(sensor, is_name) + kBetterThanNames;
  const auto is_worth_looking = [&] {
    const double beside = laws.most(sensor);
    // Names that leave nothing over are not outdone.
    return beside >= kWorthLooking * speaks_surely(s) ||
           (named && beside >= kWorthLooking * kBetterThanNames && laws.most(bare) >= outdoes);
  };
  if (!open && !drifts && lines_hz.empty() && !is_worth_looking()) return;
  std::optional<Discovered> best;
  // A name that begins and ends for no reason, on data that cannot tell it from a formula, is the formula, unless that
  // begins and ends for no more reason.
  const double for_a_while = gain_of(sensor, is_named_for_a_while);
  const double lead = for_a_while > 0.0 ? -kAlikeLeast : kBetter;
  const double clearly = for_a_while > 0.0 ? std::max(kBetterThanWindows, kAlikeShare * for_a_while) : 0.0;
  double most = worth(sensor, 0.0) + lead - kShareOfATable * gain_of(sensor, is_no_law);
  const auto value_of = [&](const Discovered& d, double margin) {
    const auto& found = d.search.found;
    const bool no_better =
        std::any_of(found.begin(), found.end(), [](const Found& f) { return is_a_window_itself(f.id); });
    return worth(d.search, d.bits) - (no_better ? std::max(margin, clearly) : margin);
  };
  const auto consider = [&](const SensorSearch& base, Least least, double margin) {
    for (const bool event : {false, true}) {
      if (event && sensor.moments_s.empty()) continue;
      auto d = terms_beside(s, laws, base, least, event);
      const double value = d ? value_of(*d, margin) : most;
      if (value > most) most = value, best = std::move(d);
    }
  };
  consider(without_some(sensor, is_open), least_gain(s, sensor, open, drifts), 0.0);
  // A law in the place of names has to be clearly better than they are.
  const double instead = std::min(kSpeaks, outdoes);
  if (named) consider(bare, {instead, instead}, open ? 0.0 : kBetterThanNames);
  if (!best) return;
  best->search.first_gain = std::max(best->search.first_gain, best->gain);
  sensor = std::move(best->search);
}

}  // namespace

void discover(const Signals& s, EngineResult& engine) {
  sensors_at_once(s, [&](Sensor k) {
    auto& sensor = engine.sensor[k];
    if (sensor && sensor->target.layout.used() > 200) discover_in(s, *sensor);
  });
}

}  // namespace stillpoint::diag
