/// From which size on effects are found: the tables of `stillpoint prove --limits`.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "diagnosis/prove/prove.h"

namespace stillpoint::diag {
namespace {

/// Size (d') at which the likelihood-ratio test of k coefficients, its law known, finds the effect in half of the cases
/// at 1 % false alarms: the noncentrality whose median is the 99 % point of chi squared. Both by the cube root of
/// Wilson and Hilferty, and of Abdel-Aty (Biometrika 41, 1954) for the noncentral one.
double likelihood_ratio_limit(double k) {
  constexpr double kNormal99 = 2.326348;
  const auto cube = [](double x) { return x * x * x; };
  const double threshold = k * cube(1.0 - 2.0 / (9.0 * k) + kNormal99 * std::sqrt(2.0 / (9.0 * k)));
  const auto median = [&](double lambda) {
    const double n = k + lambda, b = lambda / n;
    return n * cube(1.0 - 2.0 * (1.0 + b) / (9.0 * n));
  };
  double low = 0.0, high = 400.0;
  for (int i = 0; i < 60; ++i) (median(0.5 * (low + high)) < threshold ? low : high) = 0.5 * (low + high);
  return std::sqrt(0.5 * (low + high));
}

struct Trial {
  double log_ratio;  ///< of d' to the limit
  bool hit;
};

/// Logarithm of the likelihood that half of the cases are hit at `middle`, the best slope given.
double log_likelihood(const std::vector<Trial>& trials, double middle) {
  double best = -HUGE_VAL;
  for (const double slope : {3.0, 5.0, 8.0, 12.0, 20.0}) {
    double sum = 0.0;
    for (const Trial& t : trials) {
      const double x = slope * (t.log_ratio - middle);
      sum -= std::log1p(std::exp(t.hit ? -x : x));
    }
    best = std::max(best, sum);
  }
  return best;
}

/// The 50 % point with the interval in which the likelihood stays within 1.92 of its highest.
std::string half_point(const std::vector<Trial>& trials) {
  constexpr double kWithin = 1.92, kStep = 0.005, kLow = -0.5, kHigh = 2.0;
  if (trials.size() < 10) return "too few cases";
  double best = -HUGE_VAL, at = 0.0;
  for (double m = kLow; m < kHigh; m += kStep)
    if (const double l = log_likelihood(trials, m); l > best) best = l, at = m;
  double from = kHigh, to = kLow;
  for (double m = kLow; m < kHigh; m += kStep)
    if (log_likelihood(trials, m) > best - kWithin) from = std::min(from, m), to = std::max(to, m);
  return fmt::format("{:.2f} ({:.2f} to {:.2f})", std::exp(at), std::exp(from), std::exp(to));
}

}  // namespace

std::string limit_tables(const std::vector<CaseScore>& scores) {
  using Hit = std::function<bool(const CaseScore&)>;
  const auto trials = [&](const std::string& reference, const Hit& hit) {
    std::vector<Trial> all;
    for (const auto& s : scores) {
      double coefficients = 0;
      for (const auto& [id, parameters] : s.truth.effects)
        for (const auto& [symbol, values] : parameters) coefficients += static_cast<double>(values.size());
      if (s.truth.reference == reference && s.truth.d_prime > 0 && coefficients > 0)
        all.push_back({std::log(s.truth.d_prime / likelihood_ratio_limit(coefficients)), hit(s)});
    }
    return all;
  };
  const Hit found = [](const CaseScore& s) { return !s.said.empty(); };
  const Hit named = [](const CaseScore& s) { return s.outcome == "right"; };
  std::string text = fmt::format(
      "{} weak effects; size at which half are found or named, over that of the likelihood-ratio test that knows the "
      "law "
      "(1 % false alarms; 95 % intervals)\n",
      scores.size());
  for (const std::string reference : {"exact", "mocap"}) {
    const auto all = trials(reference, found);
    text += fmt::format("{} reference ({} cases): found {}, named {}\n", reference, all.size(), half_point(all),
                        half_point(trials(reference, named)));
  }
  return text;
}

}  // namespace stillpoint::diag
