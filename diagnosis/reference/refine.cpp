#include "diagnosis/reference/refine.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "diagnosis/reference/golden_section.h"
#include "diagnosis/reference/lines.h"
#include "diagnosis/reference/timing_in_window.h"

namespace stillpoint::diag {
namespace {

constexpr int kEdgeSteps = 5;
constexpr double kEdgeReach_s = 1.0;
constexpr std::size_t kMostStretches = 2;  // in which a sensor's own delay is sought: of one number, and of two
constexpr double kNatsForAnEdge = 6.0;     // logarithm of the places it could have

/// Where a gap of the fitted length begins, to the sample: the evidence summed up has its turning point there.
Eigen::Index refine_gap_once(const Signals& s, const SensorSearch& search, const NoiseModel& noise,
                             Eigen::Index begin) {
  const auto gap_law = [&](Eigen::Index from) {
    for (TimingLaw& law : make_timing_laws(s, search.sensor, from))
      if (law.id == "sys_gap") return law;
    return TimingLaw{};
  };
  const TimingLaw rough = gap_law(begin), everywhere = gap_law(1);
  const TimingFit fit = fit_timing(search.target, search.explained(), noise, rough);
  if (fit.gain_nats < 0) return begin;
  Target shifted = search.target;
  shifted.residual -= fit.delta;
  const Series3 left = fit_with(shifted, search.explained(), noise, {}).leftover, without = left + fit.delta;
  const Series3 with = without - everywhere.delta(fit.parameters);
  Series evidence = Series::Zero(s.n);
  const NoiseModel beside(search.target.layout, left);  // as for the edges of a window, below
  for (int axis = 0; axis < 3; ++axis)
    evidence += beside.whiten(search.target.layout, without.col(axis), axis).cwiseAbs2() -
                beside.whiten(search.target.layout, with.col(axis), axis).cwiseAbs2();
  for (Eigen::Index i = 1; i < s.n; ++i) evidence[i] += evidence[i - 1];
  Eigen::Index at = 0;
  evidence.minCoeff(&at);
  return std::clamp<Eigen::Index>(at + 1, 1, s.n - 1);  // the last row without it was `at`
}

/// A row off leaves thousands of nats, which the noise model takes for its colour.
Eigen::Index refine_gap(const Signals& s, const SensorSearch& search, const NoiseModel& noise, Eigen::Index begin) {
  for (int step = 0; step < kEdgeSteps; ++step) {
    const Eigen::Index moved = refine_gap_once(s, search, noise, begin);
    if (moved == begin) break;
    begin = moved;
  }
  return begin;
}

/// One pass: the best edges within reach of the given ones, or anywhere between them: where the body rests for seconds
/// the evidence does not say which way to go.
Window moved_edges(const Target& target, const Columns& explained, const Columns& everywhere, const Window& window,
                   const NoiseModel& noise) {
  const Columns windowed = in_window(everywhere, window);
  const Fit fit = fit_with(target, joined(explained, windowed), noise, {});
  const Eigen::VectorXd theta = fit.theta.tail(static_cast<Eigen::Index>(everywhere.size()));
  const Series3 without = fit.leftover + contribution_of(windowed, theta, target.layout.n);
  const Series3 with =
      without - contribution_of(everywhere, theta, target.layout.n);  // switched on in the whole recording
  Series evidence = Series::Zero(target.layout.n);
  // The noise beside the effect: with the effect in it, an autoregression would smear the edges.
  const NoiseModel beside(target.layout, fit.leftover);
  for (int axis = 0; axis < 3; ++axis)
    evidence += 0.5 * (beside.whiten(target.layout, without.col(axis), axis).cwiseAbs2() -
                       beside.whiten(target.layout, with.col(axis), axis).cwiseAbs2());
  for (Eigen::Index i = 1; i < evidence.size(); ++i) evidence[i] += evidence[i - 1];
  Window out = window;
  const auto reach = static_cast<Eigen::Index>(kEdgeReach_s / target.rows.step_s);
  const auto clip = [&](Eigen::Index i) { return std::clamp<Eigen::Index>(i, 1, target.layout.n - 1); };
  if (window.begin > 0) {
    Eigen::Index at = 0;
    const Eigen::Index lo = clip(window.begin - reach), hi = clip(std::max(window.begin + reach, window.end - reach));
    evidence.segment(lo - 1, hi - lo + 1).minCoeff(&at);
    out.begin = lo + at;
  }
  if (window.end < target.layout.n) {
    Eigen::Index at = 0;
    const Eigen::Index lo = clip(std::min(window.end - reach, window.begin + reach)), hi = clip(window.end + reach);
    evidence.segment(lo - 1, hi - lo + 1).maxCoeff(&at);
    out.end = lo + at;
  }
  return out;
}

/// A step with one edge where a second one is not needed. Bias and matrix are fitted beside every law: a step of theirs
/// that ends is the opposite step that begins, and a recording starts as the simulation says.
Window one_edge_if_enough(const Target& target, const Columns& explained, const Columns& everywhere,
                          const Window& window, const NoiseModel& noise) {
  const Eigen::Index n = target.layout.n;
  if (window.end >= n) return window;
  const auto likelihood = [&](const Window& w) {
    return fit_with(target, joined(explained, in_window(everywhere, w)), noise, {}).log_likelihood;
  };
  Window best = window;
  double least = likelihood(window) - kNatsForAnEdge;
  for (const Window& one : {Window{true, window.end, n}, Window{true, window.begin, n}}) {
    if (one.begin == 0) continue;
    const double here = likelihood(one);
    if (here > least) best = one, least = here;
  }
  return best;
}

/// A window that its evidence makes too short, held to the shortest that is believed: one edge stays where the evidence
/// has it, whichever explains more. Where its driver is zero beyond the other edge, that one is not seen anyway.
Window held_to(Eigen::Index shortest, const Target& target, const Columns& explained, const Columns& everywhere,
               const Window& tight, const NoiseModel& noise) {
  const Eigen::Index n = target.layout.n;
  Window from = tight, until = tight;
  from.end = std::min(tight.begin + shortest, n);
  until.begin = std::max<Eigen::Index>(tight.end - shortest, 0);
  const auto likelihood = [&](const Window& w) {
    return fit_with(target, joined(explained, in_window(everywhere, w)), noise, {}).log_likelihood;
  };
  return likelihood(from) >= likelihood(until) ? from : until;
}

/// A delay or a filter: what one sensor can have for a while. A clock that runs wrong does so from its start.
bool is_of_one_sensor(const TimingLaw& law) { return !law.id.starts_with("sys_"); }

Found found_from(const TimingLaw& law, const TimingFit& fit, const Window& window) {
  Found f;
  f.id = law.id;
  f.kind = Kind::kTiming;
  f.window = window;
  f.equation = law.equation;
  f.driver = law.driver;
  f.names = law.names;
  f.units = law.units;
  f.names.resize(fit.tangent.size()), f.units.resize(fit.tangent.size());
  f.columns = fit.tangent;
  f.offset = fit.delta;
  f.timing = fit.parameters;
  f.possible = law.possible;
  return f;
}

/// The shape between two logarithms that explains most beside the rest, the noise given.
void shape_between(const Target& target, const Columns& rest, double low, double high, Found& f) {
  constexpr int kSections = 12;
  const NoiseModel noise(target.layout, fit_profile(target, joined(rest, f.columns)).leftover);
  const auto gain = [&](double log_shape) {
    return fit_with(target, joined(rest, f.at_shape(std::exp(log_shape))), noise, {}).log_likelihood;
  };
  f.shape = std::exp(highest_by_golden_section(low, high, kSections, gain));
  f.columns = f.at_shape(f.shape);
}

}  // namespace

Window refine_window(const Target& target, const Columns& explained, const Law& law, const Candidate& c,
                     const NoiseModel& noise) {
  const Columns everywhere = law.columns(c.shape);
  const auto shortest = static_cast<Eigen::Index>(kShortestWindow_s / target.rows.step_s);
  Window window = c.window;
  for (int step = 0; step < kEdgeSteps; ++step) {
    const Window moved = moved_edges(target, explained, everywhere, window, noise);
    if (moved == window) break;
    if (moved.end - moved.begin < shortest) {
      window = held_to(shortest, target, explained, everywhere, moved, noise);
      break;
    }
    window = moved;
  }
  if (law.extent != Extent::kStep) return window;
  const Window step = one_edge_if_enough(target, explained, everywhere, window, noise);
  return step == window ? window : moved_edges(target, explained, everywhere, step, noise);
}

Found found_from(const Law& law, const Candidate& c, Columns columns) {
  Found f;
  f.id = law.id;
  f.kind = law.kind;
  f.window = c.window;
  f.shape = c.shape;
  f.shape_name = law.shape_name;
  f.shape_unit = law.shape_unit;
  f.unit = law.unit;
  f.equation = law.equation;
  f.driver = law.driver;
  f.form_of = law.form_of;
  f.names = law.coefficients;
  f.units = law.units.empty() ? std::vector<std::string>(law.coefficients.size(), law.unit) : law.units;
  f.columns = std::move(columns);
  f.fixed = law.fixed;
  if (!law.shape_name.empty())
    f.at_shape = [columns_of = law.columns, window = c.window](double shape) {
      return in_window(columns_of(shape), window);
    };
  return f;
}

void refine_shape(const Target& target, const Columns& explained, const std::vector<double>& grid, Found& f) {
  constexpr double kBeyond = 1.5;
  const auto at = std::find(grid.begin(), grid.end(), f.shape);
  const double low = std::log(at == grid.begin() ? grid.front() / kBeyond : *std::prev(at));
  const double high = std::log(std::next(at) == grid.end() ? grid.back() * kBeyond : *std::next(at));
  shape_between(target, explained, low, high, f);
}

void refine_shapes_again(SensorSearch& search) {
  const double reach = std::log(1.4);  // what explains more is not far from what explained most
  for (std::size_t i = 0; i + 1 < search.found.size(); ++i) {
    Found& f = search.found[i];
    const bool has_time = f.at_shape && f.shape_unit == "s";  // a level of clipping has a kink at every sample
    if (f.kind == Kind::kUnknown || (!is_line(f.id) && !has_time)) continue;  // an unknown's name holds its number
    SensorSearch without = search;
    take_out(without, i);
    if (is_line(f.id))
      sharpen_line(without, f);
    else
      shape_between(search.target, without.explained(), std::log(f.shape) - reach, std::log(f.shape) + reach, f);
  }
}

std::vector<Found> refine_timing(const Signals& s, const SensorSearch& search, const std::vector<Candidate>& shortlist,
                                 const NoiseModel& noise) {
  bool wanted = false;
  Eigen::Index gap_begin = 0;
  std::vector<const Candidate*> stretches;
  for (const Candidate& c : shortlist) {
    const Law& law = search.law(c.law);
    if (law.kind != Kind::kTiming) continue;
    wanted = true;
    if (law.id == "sys_gap" && gap_begin == 0) {
      const Window since = refine_window(search.target, search.explained(), law, c, noise);
      if (since.end == s.n) gap_begin = since.begin;
    }
    if (search.delays_in_windows && law.id != "sys_gap" && c.window.local && stretches.size() < kMostStretches)
      stretches.push_back(&c);
  }
  std::vector<Found> out;
  if (!wanted) return out;
  if (gap_begin > 0) gap_begin = refine_gap(s, search, noise, gap_begin);
  const auto refine = [&](const TimingLaw& law, const Window& window) {
    if (std::find(search.deleted.begin(), search.deleted.end(), law.id) != search.deleted.end()) return;
    const TimingFit fit = fit_timing(search.target, search.explained(), noise, law);
    if (fit.gain_nats >= 0) out.push_back(found_from(law, fit, window));
  };
  for (const TimingLaw& law : make_timing_laws(s, search.sensor, gap_begin))
    refine(law, law.id == "sys_gap" ? Window{true, gap_begin, s.n} : Window{});
  Window last;
  for (const Candidate* c : stretches) {
    const Window window = refine_window(search.target, search.explained(), search.law(c->law), *c, noise);
    if (std::exchange(last, window) == window) continue;
    for (const TimingLaw& law : make_timing_laws(s, search.sensor, 0))
      if (is_of_one_sensor(law)) refine(in_window(law, window), window);
  }
  return out;
}

}  // namespace stillpoint::diag
