#include "diagnosis/reference/selection.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "diagnosis/certainty.h"
#include "diagnosis/finding_effect.h"
#include "diagnosis/reference/adequacy.h"
#include "diagnosis/reference/evidence.h"
#include "diagnosis/reference/judge.h"
#include "diagnosis/reference/lines.h"
#include "diagnosis/reference/plausible.h"
#include "diagnosis/reference/refine.h"
#include "diagnosis/reference/scan_noise.h"
#include "diagnosis/reference/unrecorded.h"
#include "diagnosis/reference/wandering_reference.h"

namespace stillpoint::diag {
namespace {

constexpr double kNatsForTheName = 5.0;    // log of the number of laws
constexpr double kNatsForTheWindow = 8.0;  // log of the number of windows
// Of a name, for each power of ten that its numbers are smaller than usual: slow noise resembles every law a little.
constexpr double kNatsADecade = 8.0;
constexpr double kLeastShareBesideUnknown = 0.1;  // a product stands for the true law to that much only
constexpr std::size_t kShortNamed = 6, kShortUnknown = 3, kShortBesideWalk = 3;

double net_of(const Candidate& c) { return c.gain_nats - charge(static_cast<std::size_t>(c.coefficients), c.window); }

/// The first `count` laws: those of the catalogue come first.
std::vector<Candidate> look_at(const SensorSearch& search, std::size_t count, const Scan& scan) {
  std::vector<Candidate> all;
  for (std::size_t i = 0; i < count; ++i) {
    const auto some = scan.look(search.law(i), i);
    all.insert(all.end(), some.begin(), some.end());
  }
  std::sort(all.begin(), all.end(), [](const Candidate& a, const Candidate& b) { return net_of(a) > net_of(b); });
  return all;
}

/// The first few of each kind that are worth refining.
void shorten(const SensorSearch& search, const std::vector<Candidate>& all, std::size_t named, std::size_t unknown,
             std::vector<Candidate>& out) {
  for (const Candidate& c : all) {
    std::size_t& left = search.law(c.law).kind == Kind::kUnknown ? unknown : named;
    if (left == 0 || net_of(c) < 0) continue;
    const bool known = std::any_of(
        out.begin(), out.end(), [&](const Candidate& o) { return o.law == c.law && o.window.local == c.window.local; });
    if (known) continue;
    --left;
    out.push_back(c);
  }
}

/// Delay, low-pass and resonance are one response to first order, proportional to the derivative: a second one would
/// only correct the first, and both would lose their numbers.
bool is_response(const std::string& id) { return is_delay(id) || is_filter(id) || id == "unknown:dw/dt"; }
bool responds(const SensorSearch& search) {
  return std::any_of(search.found.begin(), search.found.end(), [](const Found& f) { return is_response(f.id); });
}

void add_to(SensorSearch& search, Found found) {
  if (found.offset.size()) search.target.residual -= found.offset;
  search.found.push_back(std::move(found));
}

std::vector<Candidate> short_list(const SensorSearch& search, const Judge& judge, const NoiseModel& noise) {
  const Columns explained = search.explained();
  std::vector<Candidate> out;
  const std::vector<Candidate> all =
      look_at(search, search.laws.size() + search.unknown.size(), Scan(judge.without_walk(), explained, noise));
  shorten(search, all, kShortNamed, kShortUnknown, out);
  // Whatever is a product has to stand against its own factors.
  const std::size_t products = out.size();
  for (const Candidate& c : all)
    if (std::any_of(out.begin(), out.begin() + static_cast<std::ptrdiff_t>(products), [&](const Candidate& product) {
          return product.window.local == c.window.local && is_part_of(search.law(c.law).id, search.law(product.law).id);
        }))
      shorten(search, {c}, 0, 1, out);
  if (judge.walking())
    shorten(search, look_at(search, search.laws.size(), Scan(judge.beside_walk(), explained, noise)), kShortBesideWalk,
            0, out);
  if (search.sensor == kMag) return out;
  // Whatever is local in time has to stand against a plain offset; in the magnetometer that is a law itself.
  const auto is_offset = [&](const Candidate& c) { return search.law(c.law).id == kPlainOffset; };
  const auto is_local = [](const Candidate& c) { return c.window.local; };
  const auto offset = std::find_if(all.begin(), all.end(), is_offset);
  if (offset != all.end() && std::any_of(out.begin(), out.end(), is_local) &&
      std::none_of(out.begin(), out.end(), is_offset))
    out.push_back(*offset);
  return out;
}

bool pays(const Signals& s, const SensorSearch& search, const Found& best) {
  const double least_share = search.has_unknown() ? kLeastShareBesideUnknown : kLeastShareOfFirst;
  const bool free_form = is_unknown(best.id);  // there are more products than laws
  const double least = best.window.local                    ? kLeastNetLocal
                       : search.first_gain > 0 || free_form ? kLeastNetBeside
                                                            : kLeastNet;
  if (best.net_nats < least) return false;
  const bool may_be_left_over = best.gain_nats < least_share * search.first_gain;
  if (may_be_left_over &&
      (free_form || search.has_unknown() || is_of_a_filters_form(search, best) || !leaves_only_noise(s, search, best)))
    return false;
  return best.net_nats >= least + kNatsADecade * decades_below_usual(search, best);
}

/// Between the rows at which windows that pay begin and end. Where noise wanders a jump shows in one row alone, so
/// that a law which begins a row beside it explains nothing.
void keep_moments(const std::vector<Found>& refined, SensorSearch& search) {
  for (const Found& f : refined) {
    if (!f.window.local || f.net_nats <= 0) continue;
    for (const Eigen::Index at : {f.window.begin, f.window.end}) {
      if (at <= 0 || at >= search.t_s.size()) continue;
      const double t = 0.5 * (search.t_s[at - 1] + search.t_s[at]);
      auto& all = search.moments_s;
      if (std::find(all.begin(), all.end(), t) == all.end()) all.push_back(t);
    }
  }
}

/// A law that fits a window and predicts nothing outside of its fit: something begins or ends there all the same.
std::optional<Found> nameless_instead(const Signals& s, const SensorSearch& search, const std::vector<Found>& sorted) {
  const auto plain =
      std::find_if(sorted.begin(), sorted.end(), [](const Found& f) { return f.id == kPlainOffset && f.window.local; });
  if (plain == sorted.end() || !pays(s, search, *plain) ||
      is_a_trace_of_the_cameras(s, search, *plain, fit_beside(search, *plain)))
    return std::nullopt;
  return *plain;
}

/// The best of the sorted ones that is worth its charge and that no driver outside of the recording outdoes.
std::optional<Found> chosen(const Signals& s, const SensorSearch& search, const Judge& judge,
                            std::vector<Found> sorted) {
  while (auto best = best_explanation(sorted, s.current_A.size() > 0)) {
    const std::string id = best->id;
    best = adequate(s, search, judge, std::move(*best));
    if (!pays(s, search, *best)) return std::nullopt;
    if (!possible(s, search, *best)) return std::nullopt;  // what comes next would take the same misfit's place
    if (!leaves_less(search, *best)) return std::nullopt;
    const Fit beside = best->offset.size() ? Fit{} : fit_beside(search, *best);  // a timing law has no use for it
    if (robust_nats(search, *best, beside) < charge(best->names.size(), best->window)) return std::nullopt;
    if (is_unknown(best->id) && !varies(search, *best, beside)) return std::nullopt;
    if (is_unknown(best->id) && !best->offset.size() && !search.found.empty() &&
        moves_the_others(search, fit_profile(search.beside_walk(), search.explained()), beside))
      return std::nullopt;
    if (is_a_trace_of_the_cameras(s, search, *best, beside)) return std::nullopt;
    // Half a milliradian of a camera's calibration is as large as a good magnetometer's noise, and turns gravity by
    // more than temperature moves a good accelerometer: no name is stated of it.
    const bool may_be_the_camera = search.sensor == kMag || (is_unknown(best->id) && !best->window.local) ||
                                   (search.sensor == kAcc && as_small_as_wandering(s, search, *best, beside));
    if (may_be_the_camera && !stands_beside_wandering(s, search, *best)) return std::nullopt;
    best = against_the_unrecorded(s, search, judge, std::move(*best));
    if (best) return best;
    std::erase_if(sorted, [&](const Found& f) { return f.id == id; });
  }
  return std::nullopt;
}

}  // namespace

Target SensorSearch::beside_walk() const {
  Target t = target;
  t.walk = walk;
  return t;
}

Columns SensorSearch::explained() const {
  Columns all;
  for (const Found& f : found) all.insert(all.end(), f.columns.begin(), f.columns.end());
  return all;
}

bool SensorSearch::has_unknown() const {
  return std::any_of(found.begin(), found.end(), [](const Found& f) { return f.kind == Kind::kUnknown; });
}

double charge(std::size_t coefficients, const Window& window) {
  return kNatsForTheName + kNatsPerCoefficient * static_cast<double>(coefficients) +
         (window.local ? kNatsForTheWindow : 0.0);
}

SensorSearch start_search(const Signals& s, Sensor sensor, const std::vector<std::string>& without) {
  SensorSearch search;
  search.sensor = sensor;
  search.target = make_target(s, sensor);
  search.laws = make_laws(s, sensor);
  search.unknown = make_unknown_laws(s, sensor);
  search.deleted = without;
  std::erase_if(search.laws, [&](const Law& law) { return contains(without, law.id); });
  std::erase_if(search.unknown, [&](const Law& product) {
    return std::any_of(search.laws.begin(), search.laws.end(),
                       [&](const Law& law) { return law.id == product.form_of; });
  });
  search.walk = walk_basis(s);
  search.walk_is_given = s.triad[sensor].random_walk_per_sqrts > 0 || s.triad[sensor].bias_instability > 0;
  search.t_s = s.t_s;
  return search;
}

std::optional<Found> next_effect(const Signals& s, SensorSearch& search) {
  const Columns explained = search.explained();
  const Judge judge(search);
  const NoiseModel noise = scan_noise(judge.without_walk(), explained, *search.walk);
  const std::vector<Candidate> shortlist = short_list(search, judge, noise);

  const bool responded = responds(search);
  std::vector<Found> refined;
  if (!responded) refined = refine_timing(s, search, shortlist, noise);
  if (const auto line = line_in(s, search); line && !contains(search.deleted, line->id)) refined.push_back(*line);
  for (Candidate c : shortlist) {
    const Law& law = search.law(c.law);
    if (law.kind == Kind::kTiming || (responded && is_response(law.id))) continue;
    if (c.window.local) c.window = refine_window(search.target, explained, law, c, noise);
    refined.push_back(found_from(law, c, in_window(law.columns(c.shape), c.window)));
    Found& f = refined.back();
    if (f.at_shape) refine_shape(search.target, explained, law.shapes, f);
    if (!law.text.empty()) f.id = "unknown:" + fmt::format(fmt::runtime(law.text), fmt::format("{:.5g}", f.shape));
  }
  for (Found& f : refined) judge.weigh(f);
  std::sort(refined.begin(), refined.end(), [](const Found& a, const Found& b) { return a.net_nats > b.net_nats; });
  std::vector<Ranked> ranking;
  ranking.reserve(refined.size());
  for (const Found& f : refined) ranking.push_back({f.id, f.window, f.gain_nats, f.net_nats});
  if (search.found.empty()) search.ranking = ranking;
  keep_moments(refined, search);

  const auto is_told_by_others = [&](const Found& f) {
    SensorSearch with = search;
    add_to(with, f);
    return predicts(held_out(with, {with.found.size() - 1}));
  };
  std::optional<Found> best = chosen(s, search, judge, refined);
  if (best && !is_told_by_others(*best)) {
    best = best->window.local ? nameless_instead(s, search, refined) : std::nullopt;
    if (best && !is_told_by_others(*best)) best.reset();
  }
  if (best) best->rivals = std::move(ranking);
  return best;
}

void accept(SensorSearch& search, Found found) {
  // What the body does says nothing of how small an effect may be.
  if (found.id != kBodyVibration) search.first_gain = std::max(search.first_gain, found.gain_nats);
  add_to(search, std::move(found));
  if (search.found.size() < 2) return;
  refine_shapes_again(search);
  weigh_again(search, search.found.size() - 1);
}

void weigh_again(SensorSearch& search, std::size_t count) {
  const double all = fit_profile(search.beside_walk(), search.explained()).log_likelihood;
  for (std::size_t i = 0; i < count; ++i) {
    SensorSearch without = search;
    take_out(without, i);
    Found& f = search.found[i];
    f.gain_nats = all - fit_profile(without.beside_walk(), without.explained()).log_likelihood;
    f.net_nats = f.gain_nats - charge(f.columns.size(), f.window);
    if (f.net_nats > 0) continue;
    search = std::move(without);
    return;
  }
}

Fit fit_beside(const SensorSearch& search, const Found& law) {
  return fit_profile(search.beside_walk(), joined(search.explained(), law.columns));
}

Series3 effect_of(const Found& law, const Fit& beside) {
  const Eigen::VectorXd theta = beside.theta.tail(static_cast<Eigen::Index>(law.columns.size()));
  return contribution_of(law.columns, theta, beside.leftover.rows());
}

double robust_nats(const SensorSearch& search, const Found& law, const Fit& beside) {
  if (law.offset.size() || law.columns.empty()) return law.gain_nats;
  const Target t = search.beside_walk();
  const Columns columns = joined(search.explained(), law.columns);
  const Eigen::MatrixXd all = robust_covariance(t, columns, NoiseModel(t.layout, beside.leftover), beside.walk_q);
  if (all.size() == 0) return law.gain_nats;
  const auto p = static_cast<Eigen::Index>(law.columns.size());
  const Eigen::VectorXd theta = beside.theta.tail(p);
  return std::min(law.gain_nats, 0.5 * theta.dot(all.bottomRightCorner(p, p).ldlt().solve(theta)));
}

Series3 beyond_matrix(const SensorSearch& search, const Series3& effect) {
  const Eigen::MatrixXd z = search.target.layout.counts.matrix().asDiagonal() * search.target.nuisance;
  const Series3 seen = search.target.layout.counts.matrix().asDiagonal() * effect;
  return seen - z * z.colPivHouseholderQr().solve(seen);
}

bool varies(const SensorSearch& search, const Found& law, const Fit& beside) {
  constexpr double kTrace = 0.01;
  if (law.offset.size() || law.columns.empty()) return true;
  const Series3 effect = effect_of(law, beside);
  return beyond_matrix(search, effect).norm() > kTrace * effect.norm();
}

void take_out(SensorSearch& search, std::size_t index) {
  const Found& f = search.found[index];
  if (f.offset.size()) search.target.residual += f.offset;
  search.found.erase(search.found.begin() + static_cast<std::ptrdiff_t>(index));
}

double gain_of_offset(const SensorSearch& search, const Series3& offset) {
  Target shifted = search.target;
  const Columns explained = search.explained();
  const double before = fit_profile(shifted, explained).log_likelihood;
  shifted.residual -= offset;
  return fit_profile(shifted, explained).log_likelihood - before;
}

}  // namespace stillpoint::diag
