#include "diagnosis/reference/timing.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "diagnosis/reference/columns.h"
#include "diagnosis/reference/response.h"

namespace stillpoint::diag {
namespace {

constexpr int kGaussNewtonSteps = 6;
constexpr double kLikeness_s = 0.04;
constexpr Eigen::Index kNeighbours = 3;
constexpr std::size_t kStartsRefined = 2;
constexpr double kNatsANumber = 8.0;    // what one more has to explain
constexpr double kLeastDamping = 0.01;  // half of what mounts and glued parts have (docs/effects.md, A12)

/// What a sensor with this response shows beyond the truth. When the truth is the sensor itself (a noisy reference),
/// the response is undone instead: u - u / h.
Series3 beyond_truth(const Signals& s, Sensor k, const Response& h) {
  const bool from_truth = !vector_is_reading(s, k);
  const Response low = low_pass(0.33 / s.dt_s);  // zero at Nyquist, where the inverse of a response is lost
  const Response gain = from_truth ? Response([h](double f) { return h(f) - 1.0; })
                                   : Response([h, low](double f) { return (1.0 - 1.0 / h(f)) * low(f); });
  return at_rest_zero(s, apply_response(s.vector[k], s.rows, gain));
}

/// u(t) = true(t + int r dt), r = epsilon, or epsilon + k (T - T0); when the truth is the sensor itself, the clock is
/// set right instead.
Series3 skewed(const Signals& s, Sensor k, const Eigen::VectorXd& p) {
  const bool from_truth = !vector_is_reading(s, k);
  const double last = static_cast<double>(s.n - 1);
  const Series t_s = s.rows.even() ? Series::LinSpaced(s.n, 0.0, last * s.rows.step_s) : s.rows.t_s;
  Series rate = Series::Constant(s.n, p[0]), late = p[0] * t_s;
  if (p.size() == 2) rate += p[1] * s.temperature_K, late += p[1] * integral(s.temperature_K, s.dt_s);
  if (!from_truth) late = -late.array() / (1.0 + rate.array());
  const Series3 moved = at_times(s.vector[k], s.rows, t_s + late, kNeighbours);
  return at_rest_zero(s, from_truth ? Series3(moved - s.vector[k]) : Series3(s.vector[k] - moved));
}

/// A clock's rate, and the same with a temperature that it follows, where that changes.
TimingLaw skew(const Signals& s, Sensor k) {
  constexpr double kFollows_K = 3.0;
  TimingLaw law{"sys_skew",
                {"epsilon", "k"},
                {"1", "1/K"},
                "u(t) = true(t + int (epsilon + k (T - T0)) dt)",
                "time times the first derivative",
                {Eigen::VectorXd::Zero(1)},
                [](const Eigen::VectorXd&) { return true; },
                [&s, k](const Eigen::VectorXd& p) { return skewed(s, k, p); }};
  // Motion keeps its likeness for some 40 ms: the grid must not step over that by the end.
  const Series& T = s.temperature_K;
  const bool follows = T.size() > 0 && T.maxCoeff() - T.minCoeff() > kFollows_K;
  const double warmth_Ks = follows ? integral((T.array() - T[0]).matrix(), s.dt_s)[s.n - 1] : 0.0;
  const bool tells = std::abs(warmth_Ks) > s.duration_s();  // a kelvin in the mean
  for (double shift_s = kLikeness_s; shift_s < 0.0105 * s.duration_s(); shift_s += kLikeness_s)
    for (const double sign : {1.0, -1.0}) {
      law.starts.push_back(Eigen::VectorXd::Constant(1, sign * shift_s / s.duration_s()));
      if (tells) law.starts.push_back(sign * shift_s / warmth_Ks * Eigen::Vector2d(-T[0], 1.0));
    }
  return law;
}

TimingLaw one_number(std::string id, std::string name, std::string unit, std::string equation, std::string driver,
                     const std::vector<double>& starts, std::function<Series3(double)> delta) {
  TimingLaw law{
      std::move(id), {std::move(name)}, {std::move(unit)}, std::move(equation), std::move(driver), {}, {}, {}};
  for (const double x : starts) law.starts.push_back(Eigen::VectorXd::Constant(1, x));
  law.possible = [](const Eigen::VectorXd&) { return true; };
  law.delta = [delta = std::move(delta)](const Eigen::VectorXd& p) { return delta(p[0]); };
  return law;
}

}  // namespace

std::vector<TimingLaw> make_timing_laws(const Signals& s, Sensor k, Eigen::Index gap_begin) {
  const std::string prefix = std::string(kSensorName[k]) + "_";
  std::vector<TimingLaw> laws;
  laws.push_back(one_number(prefix + "delay", "tau", "s", "u(t) = true(t - tau)",
                            "first derivative of the measured vector", {0.0},
                            [&s, k](double tau) { return beyond_truth(s, k, delay_response(tau)); }));
  if (k != kMag) {
    TimingLaw filter =
        one_number(prefix + "lpf", "tau", "s", "u = true / (1 + s tau)", "first derivative of the measured vector",
                   {1e-3}, [&s, k](double tau) { return beyond_truth(s, k, first_order_response(tau)); });
    filter.possible = [](const Eigen::VectorXd& p) { return p[0] > 1e-5 && p[0] < 0.2; };
    laws.push_back(std::move(filter));
    TimingLaw resonance{prefix + "resonance",
                        {"f_n", "zeta"},
                        {"Hz", "1"},
                        "u = w^2 / (s^2 + 2 zeta w s + w^2) true, w = 2 pi f_n",
                        "second derivative of the measured vector",
                        {},
                        {},
                        {}};
    for (const double f : {15.0, 30.0}) resonance.starts.push_back(Eigen::Vector2d(std::min(f, 0.4 / s.dt_s), 0.1));
    const double lowest = 6.0;
    resonance.possible = [lowest](const Eigen::VectorXd& p) {
      return p[0] > lowest && p[0] < 2000 && p[1] > kLeastDamping && p[1] < 0.5;
    };
    resonance.delta = [&s, k](const Eigen::VectorXd& p) { return beyond_truth(s, k, resonance_response(p[0], p[1])); };
    if (k == kAcc) laws.push_back(std::move(resonance));
  }
  if (gap_begin > 0) {
    TimingLaw gap = one_number("sys_gap", "shift", "s", "u(t) = true(t - n/fs) from t0 on",
                               "first derivative of the measured vector", {}, [&s, k, gap_begin](double tau) {
                                 Series3 d = beyond_truth(s, k, delay_response(tau));
                                 d.topRows(gap_begin).setZero();
                                 return d;
                               });
    for (int n : {-50, -35, -25, -17, -12, -8, -5, -3, -2, -1, 1, 2, 3, 5, 8, 12})
      gap.starts.push_back(Eigen::VectorXd::Constant(1, n * s.dt_s));
    laws.push_back(std::move(gap));
  }
  laws.push_back(skew(s, k));
  return laws;
}

TimingFit fit_timing(const Target& target, const Columns& explained, const NoiseModel& noise, const TimingLaw& law) {
  const std::array<double, 3> no_walk{};
  const double before = fit_with(target, explained, noise, no_walk).log_likelihood;
  TimingFit best;
  const auto is_better = [&best](double gain_nats, Eigen::Index numbers) {
    const Eigen::Index more = best.parameters.size() == 0 ? 0 : numbers - best.parameters.size();
    return gain_nats > best.gain_nats + kNatsANumber * static_cast<double>(more);
  };
  const auto gain_at = [&](const Eigen::VectorXd& p) {
    Target shifted = target;
    shifted.residual -= law.delta(p);
    return fit_with(shifted, explained, noise, no_walk).log_likelihood - before;
  };
  std::vector<std::pair<double, Eigen::VectorXd>> starts;
  for (const Eigen::VectorXd& start : law.starts)
    starts.emplace_back(law.starts.size() > kStartsRefined ? gain_at(start) : 0.0, start);
  std::sort(starts.begin(), starts.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  std::map<Eigen::Index, std::size_t> refined;  // by how many numbers
  for (const auto& [gain, start] : starts) {
    if (refined[start.size()]++ >= kStartsRefined) continue;
    Eigen::VectorXd p = start;
    double reached = -1e300;
    for (int step = 0; step < kGaussNewtonSteps; ++step) {
      const Series3 delta = law.delta(p);
      Columns columns = explained, tangent;
      for (Eigen::Index j = 0; j < p.size(); ++j) {
        Eigen::VectorXd moved = p;
        const double h = 1e-3 * std::abs(p[j]) + 1e-6;
        moved[j] += h;
        tangent.push_back({-1, (law.delta(moved) - delta) / h});
      }
      columns.insert(columns.end(), tangent.begin(), tangent.end());
      Target shifted = target;
      shifted.residual = target.residual - delta;
      const double here = fit_with(shifted, explained, noise, no_walk).log_likelihood;
      if (is_better(here - before, p.size())) best = {p, tangent, delta, here - before};
      if (step > 0 && here < reached + 1e-3) break;
      reached = here;
      const Fit fit = fit_with(shifted, columns, noise, no_walk);
      Eigen::VectorXd update = fit.theta.tail(p.size());
      double damping = 1.0;
      while (damping > 1e-3 && !law.possible(p + damping * update)) damping *= 0.5;
      if (!law.possible(p + damping * update)) break;
      p += damping * update;
    }
  }
  return best;
}

}  // namespace stillpoint::diag
