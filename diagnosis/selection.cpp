#include "diagnosis/selection.h"

#include <algorithm>
#include <cmath>

namespace stillpoint::diag {
namespace {

constexpr double kNatsPerCoefficient = 2.0;
constexpr double kNatsForTheName = 5.0;    // log of the number of laws
constexpr double kNatsForTheWindow = 8.0;  // log of the number of windows
constexpr double kLeastNet = 3.0;
constexpr double kLeastShareOfFirst = 0.02;  // the remainder of a large effect must not get a name of its own
constexpr double kArmsAgree = 0.95;
constexpr std::size_t kShortNamed = 6, kShortUnknown = 2, kShortBesideWalk = 3;
constexpr double kWalkWorthwhile = 2.0;
constexpr double kWalkFreedom = 8.0;  // what three rates of a random walk and their name are worth

double net_of(const Candidate& c) { return c.gain_nats - charge(static_cast<std::size_t>(c.coefficients), c.window); }

const Law& law_of(const SensorSearch& search, std::size_t index) {
  return index < search.laws.size() ? search.laws[index] : search.unknown[index - search.laws.size()];
}

std::vector<Candidate> look_at_all(const SensorSearch& search, const Scan& scan) {
  std::vector<Candidate> all;
  for (std::size_t i = 0; i < search.laws.size() + search.unknown.size(); ++i) {
    const auto some = scan.look(law_of(search, i), i);
    all.insert(all.end(), some.begin(), some.end());
  }
  std::sort(all.begin(), all.end(), [](const Candidate& a, const Candidate& b) { return net_of(a) > net_of(b); });
  return all;
}

/// The first few of each kind that are worth refining.
void shorten(const SensorSearch& search, const std::vector<Candidate>& all, std::size_t named, std::size_t unknown,
             std::vector<Candidate>& out) {
  for (const Candidate& c : all) {
    const bool is_unknown = law_of(search, c.law).kind == Kind::kUnknown;
    std::size_t& left = is_unknown ? unknown : named;
    if (left == 0 || net_of(c) < 0) continue;
    const bool known = std::any_of(
        out.begin(), out.end(), [&](const Candidate& o) { return o.law == c.law && o.window.local == c.window.local; });
    if (known) continue;
    --left;
    out.push_back(c);
  }
}

Columns joined(Columns a, const Columns& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

/// Moves the edges of a window to the sample: the prefix sum of the evidence has its turning points there.
Window refine_window(const Target& target, const Columns& explained, const Law& law, const Candidate& c,
                     const NoiseModel& noise) {
  const Columns everywhere = law.columns(c.shape);
  const Fit fit = fit_with(target, joined(explained, in_window(everywhere, c.window)), noise, {});
  Series3 with = fit.leftover;  // the law switched on in the whole recording
  const auto first = static_cast<Eigen::Index>(explained.size());
  for (std::size_t j = 0; j < everywhere.size(); ++j) {
    const double theta = fit.theta[first + static_cast<Eigen::Index>(j)];
    const Columns windowed = in_window({everywhere[j]}, c.window);
    for (int axis = 0; axis < 3; ++axis)
      if (const auto all = shown_in(everywhere[j], axis))
        with.col(axis) -= theta * (*all - *shown_in(windowed[0], axis));
  }
  Series3 without = fit.leftover;
  for (std::size_t j = 0; j < everywhere.size(); ++j) {
    const Columns windowed = in_window({everywhere[j]}, c.window);
    for (int axis = 0; axis < 3; ++axis)
      if (const auto in = shown_in(windowed[0], axis))
        without.col(axis) += fit.theta[first + static_cast<Eigen::Index>(j)] * *in;
  }
  Series evidence = Series::Zero(target.layout.n);
  for (int axis = 0; axis < 3; ++axis)
    evidence += 0.5 * (noise.whiten(target.layout, without.col(axis), axis).cwiseAbs2() -
                       noise.whiten(target.layout, with.col(axis), axis).cwiseAbs2());
  for (Eigen::Index i = 1; i < evidence.size(); ++i) evidence[i] += evidence[i - 1];
  Window out = c.window;
  const auto reach = static_cast<Eigen::Index>(0.75 / target.dt_s);
  const auto clip = [&](Eigen::Index i) { return std::clamp<Eigen::Index>(i, 1, target.layout.n - 1); };
  if (c.window.begin > 0) {
    Eigen::Index at = 0;
    const Eigen::Index lo = clip(c.window.begin - reach), hi = clip(c.window.begin + reach);
    evidence.segment(lo - 1, hi - lo + 1).minCoeff(&at);
    out.begin = lo + at;
  }
  if (c.window.end < target.layout.n) {
    Eigen::Index at = 0;
    const Eigen::Index lo = clip(c.window.end - reach), hi = clip(c.window.end + reach);
    evidence.segment(lo - 1, hi - lo + 1).maxCoeff(&at);
    out.end = lo + at;
  }
  return out;
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
  f.names = law.coefficients;
  f.units.assign(law.coefficients.size(), law.unit);
  f.columns = std::move(columns);
  // A level of clipping has a shape too, but its likelihood has a kink at every sample.
  if (law.shape_unit == "s")
    f.at_shape = [columns_of = law.columns, window = c.window](double shape) {
      return in_window(columns_of(shape), window);
    };
  return f;
}

/// The time constant between the points of the grid (beyond it at its ends) that explains most: golden section in its
/// logarithm, the noise given.
void refine_shape(const Target& target, const Columns& explained, const std::vector<double>& grid, Found& f) {
  constexpr int kSections = 12;
  constexpr double kGolden = 0.6180339887498949, kBeyond = 3.0;
  const NoiseModel noise(target.layout, fit_profile(target, joined(explained, f.columns)).leftover);
  const auto gain = [&](double log_shape) {
    return fit_with(target, joined(explained, f.at_shape(std::exp(log_shape))), noise, {}).log_likelihood;
  };
  const auto at = std::find(grid.begin(), grid.end(), f.shape);
  double low = std::log(at == grid.begin() ? grid.front() / kBeyond : *std::prev(at));
  double high = std::log(std::next(at) == grid.end() ? grid.back() * kBeyond : *std::next(at));
  double a = high - kGolden * (high - low), b = low + kGolden * (high - low);
  double gain_a = gain(a), gain_b = gain(b);
  for (int i = 0; i < kSections; ++i) {
    if (gain_a > gain_b) {
      high = b, b = a, gain_b = gain_a, a = high - kGolden * (high - low), gain_a = gain(a);
    } else {
      low = a, a = b, gain_a = gain_b, b = low + kGolden * (high - low), gain_b = gain(b);
    }
  }
  f.shape = std::exp(0.5 * (low + high));
  f.columns = f.at_shape(f.shape);
}

/// Where a gap of the fitted length begins, to the sample: the evidence summed up has its turning point there.
Eigen::Index refine_gap(const Signals& s, const SensorSearch& search, const NoiseModel& noise, Eigen::Index begin) {
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
  const Series3 without = fit_with(shifted, search.explained(), noise, {}).leftover + fit.delta;
  const Series3 with = without - everywhere.delta(fit.parameters);
  Series evidence = Series::Zero(s.n);
  for (int axis = 0; axis < 3; ++axis)
    evidence += noise.whiten(search.target.layout, without.col(axis), axis).cwiseAbs2() -
                noise.whiten(search.target.layout, with.col(axis), axis).cwiseAbs2();
  for (Eigen::Index i = 1; i < s.n; ++i) evidence[i] += evidence[i - 1];
  Eigen::Index at = 0;
  evidence.minCoeff(&at);
  return std::clamp<Eigen::Index>(at, 1, s.n - 1);
}

/// Delay, low-pass and resonance are one response to first order, proportional to the derivative: a second one would
/// only correct the first, and both would lose their numbers.
bool is_response(const std::string& id) {
  return id.ends_with("_delay") || id.ends_with("_lpf") || id.ends_with("_resonance") || id == "sys_offset" ||
         id == "unknown:dw/dt";
}
bool responds(const SensorSearch& search) {
  return std::any_of(search.found.begin(), search.found.end(), [](const Found& f) { return is_response(f.id); });
}

/// The timing laws, when the scan saw something that changes with the derivative of the measured vector.
std::vector<Found> refine_timing(const Signals& s, const SensorSearch& search, const std::vector<Candidate>& shortlist,
                                 const NoiseModel& noise, double null_likelihood) {
  bool wanted = false;
  Eigen::Index gap_begin = 0;
  for (const Candidate& c : shortlist) {
    const Law& law = law_of(search, c.law);
    if (law.kind != Kind::kTiming) continue;
    wanted = true;
    if (law.id == "sys_gap" && c.window.end == s.n && gap_begin == 0)
      gap_begin = refine_window(search.target, search.explained(), law, c, noise).begin;
  }
  std::vector<Found> out;
  if (!wanted || responds(search)) return out;
  if (gap_begin > 0) gap_begin = refine_gap(s, search, noise, gap_begin);
  for (const TimingLaw& law : make_timing_laws(s, search.sensor, gap_begin)) {
    if (std::find(search.deleted.begin(), search.deleted.end(), law.id) != search.deleted.end()) continue;
    const TimingFit fit = fit_timing(search.target, search.explained(), noise, law);
    if (fit.gain_nats < 0) continue;
    Target shifted = search.target;
    shifted.residual -= fit.delta;
    Found f;
    f.id = law.id;
    f.kind = Kind::kTiming;
    f.window = law.id == "sys_gap" ? Window{true, gap_begin, s.n} : Window{};
    f.equation = law.equation;
    f.driver = law.driver;
    f.names = law.names;
    f.units = law.units;
    f.columns = fit.tangent;
    f.offset = fit.delta;
    f.timing = fit.parameters;
    f.gain_nats = fit_profile(shifted, search.explained()).log_likelihood - null_likelihood;
    f.net_nats = f.gain_nats - charge(law.names.size(), f.window);
    out.push_back(std::move(f));
  }
  return out;
}

}  // namespace

Columns SensorSearch::explained() const {
  Columns all;
  for (const Found& f : found) all.insert(all.end(), f.columns.begin(), f.columns.end());
  return all;
}

double charge(std::size_t coefficients, const Window& window) {
  return kNatsForTheName + kNatsPerCoefficient * static_cast<double>(coefficients) +
         (window.local ? kNatsForTheWindow : 0.0);
}

NoiseModel scan_noise(const Target& target, const Columns& explained, const Eigen::MatrixXd& walk) {
  // A flexible smooth model in ordinary least squares: slow cosines, and second and third powers of the measured
  // vector.
  Columns flexible = explained;
  const Eigen::MatrixXd v = target.nuisance.rightCols(3);
  const Series3 rate = derivative(v, target.dt_s);
  const Series3 second = second_derivative(v, target.dt_s);
  for (int axis = 0; axis < 3; ++axis) {
    for (Eigen::Index k = 0; k < std::min<Eigen::Index>(walk.cols(), 16); ++k) flexible.push_back({axis, walk.col(k)});
    for (int i = 0; i < 3; ++i) {
      flexible.push_back({axis, v.col(i).cwiseAbs2()});
      flexible.push_back({axis, rate.col(i)});
      flexible.push_back({axis, second.col(i)});
    }
    flexible.push_back({axis, v.col(axis).array().cube()});
  }
  Target plain = target;
  plain.walk.resize(0, 0);
  plain.layout.order = 0;
  const Fit fit = fit_with(plain, flexible, NoiseModel(plain.layout, plain.residual), {});
  return NoiseModel(target.layout, fit.leftover);
}

SensorSearch start_search(const Signals& s, Sensor sensor) {
  SensorSearch search;
  search.sensor = sensor;
  search.target = make_target(s, sensor);
  search.laws = make_laws(s, sensor);
  search.unknown = make_unknown_laws(s, sensor);
  search.walk = walk_basis(s);
  return search;
}

std::optional<Found> next_effect(const Signals& s, SensorSearch& search) {
  Target& t = search.target;
  const Columns explained = search.explained();
  t.walk.resize(0, 0);
  double null = fit_profile(t, explained).log_likelihood;
  t.walk = search.walk;
  const double with_walk = fit_profile(t, explained).log_likelihood;
  const bool walking = with_walk > null + kWalkWorthwhile;
  if (walking) null = with_walk;
  if (search.found.empty()) search.null_likelihood = null;

  t.walk.resize(0, 0);
  const NoiseModel noise = scan_noise(t, explained, search.walk);
  std::vector<Candidate> shortlist;
  shorten(search, look_at_all(search, Scan(t, explained, noise)), kShortNamed, kShortUnknown, shortlist);
  if (walking) {
    t.walk = search.walk;
    shorten(search, look_at_all(search, Scan(t, explained, noise)), kShortBesideWalk, kShortUnknown, shortlist);
  }
  std::vector<Found> refined = refine_timing(s, search, shortlist, noise, null);
  for (Candidate& c : shortlist) {
    const Law& law = law_of(search, c.law);
    if (law.kind == Kind::kTiming || (responds(search) && is_response(law.id))) continue;
    if (c.window.local) c.window = refine_window(t, explained, law, c, noise);
    Found f = found_from(law, c, in_window(law.columns(c.shape), c.window));
    const Fit fit = fit_profile(t, joined(explained, f.columns));
    f.gain_nats = fit.log_likelihood - null;
    f.net_nats = f.gain_nats - charge(f.columns.size(), f.window);
    // A driver that leaves no drift has bought out the walk that the baseline needed.
    const bool drift_gone = fit.walk_q[0] == 0.0 && fit.walk_q[1] == 0.0 && fit.walk_q[2] == 0.0;
    if (walking && drift_gone) f.net_nats += kWalkFreedom;
    refined.push_back(std::move(f));
  }
  std::sort(refined.begin(), refined.end(), [](const Found& a, const Found& b) { return a.net_nats > b.net_nats; });
  search.last_round.clear();
  for (const Found& f : refined) search.last_round.push_back({f.id, f.window, f.gain_nats, f.net_nats});
  if (search.found.empty()) search.ranking = search.last_round;
  const auto named =
      std::find_if(refined.begin(), refined.end(), [](const Found& f) { return f.kind != Kind::kUnknown; });
  auto best = refined.begin();
  if (best == refined.end()) return std::nullopt;
  if (best->kind == Kind::kUnknown && named != refined.end() &&
      best->net_nats < named->net_nats + std::max(6.0, 0.05 * named->gain_nats))
    best = named;
  // The size effect contains the lever arm: three arms that agree are one.
  if (best->id == "acc_size")
    for (auto f = refined.begin(); f != refined.end(); ++f)
      if (f->id == "acc_lever" && f->gain_nats > kArmsAgree * best->gain_nats) best = f;
  if (best->net_nats < kLeastNet || best->gain_nats < kLeastShareOfFirst * search.first_gain) return std::nullopt;
  if (best->at_shape) {
    const auto law = std::find_if(search.laws.begin(), search.laws.end(),
                                  [&](const Law& l) { return l.id == best->id && l.shape_name == best->shape_name; });
    if (law != search.laws.end()) refine_shape(t, explained, law->shapes, *best);
  }
  return *best;
}

void accept(SensorSearch& search, Found found) {
  if (search.found.empty()) search.first_gain = found.gain_nats;
  search.first_gain = std::max(search.first_gain, found.gain_nats);
  if (found.offset.size()) search.target.residual -= found.offset;
  search.found.push_back(std::move(found));
  if (search.found.size() < 2) return;
  search.target.walk = search.walk;
  const double all = fit_profile(search.target, search.explained()).log_likelihood;
  for (std::size_t i = 0; i + 1 < search.found.size(); ++i) {
    SensorSearch without = search;
    if (search.found[i].offset.size()) without.target.residual += search.found[i].offset;
    without.found.erase(without.found.begin() + static_cast<std::ptrdiff_t>(i));
    const double less = fit_profile(without.target, without.explained()).log_likelihood;
    search.found[i].gain_nats = all - less;
    search.found[i].net_nats = all - less - charge(search.found[i].columns.size(), search.found[i].window);
    if (search.found[i].net_nats > 0) continue;
    search = std::move(without);
    return;
  }
}

double gain_of_offset(const SensorSearch& search, const Series3& offset) {
  Target plain = search.target;
  plain.walk.resize(0, 0);
  const Columns explained = search.explained();
  const double before = fit_profile(plain, explained).log_likelihood;
  plain.residual -= offset;
  return fit_profile(plain, explained).log_likelihood - before;
}

}  // namespace stillpoint::diag
