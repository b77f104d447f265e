#include "diagnosis/forensics/lattice.h"
#include "core/units.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace stillpoint::diag {
namespace {

constexpr std::array<double, 3> kUnits{1.0, kStandardGravity_mps2, kRadPerDeg};
constexpr double kLeastStepOverPrinted = 2.5;  // finer lattices drown in the rounding of the file
constexpr double kFloat32Relative = 4e-7;      // numbers kept as 32-bit floats lie on a lattice of this relative step
constexpr double kLeastEvidence_nats = 30.0;   // chance of as regular values from a continuous law: e^-30
constexpr double kLeastShare = 0.995;          // a few values (rails, zeros) may lie off the lattice

std::vector<double> distinct_values(std::span<const double> values, double apart) {
  std::vector<double> u;
  u.reserve(values.size());
  for (const double v : values)
    if (std::isfinite(v)) u.push_back(v);
  std::sort(u.begin(), u.end());
  u.erase(std::unique(u.begin(), u.end(), [apart](double a, double b) { return b - a < apart; }), u.end());
  return u;
}

/// Sharpens a first guess of the step with ever longer differences, so that the count of steps is never in doubt.
double sharpen(const std::vector<double>& sorted_differences, double guess, double printed) {
  double sum = 0.0, steps = 0.0, step = guess;
  for (const double d : sorted_differences) {
    const double k = std::round(d / step);
    if (k < 1.0 || k * printed > 0.3 * step * std::max(steps, 1.0)) continue;
    if (std::abs(d - k * step) > 1.1 * printed + 1e-3 * step) continue;
    sum += d;
    steps += k;
    step = sum / steps;
  }
  return step;
}

struct LineFit {
  double origin = 0.0, step = 0.0, step_sd = 0.0;
  std::size_t inliers = 0;
};

/// Least squares of value = origin + step * index over the values that lie within the file's rounding of the lattice.
LineFit fit_lattice(const std::vector<double>& u, double step, double printed) {
  LineFit fit{.origin = u.front(), .step = step};
  const double tolerance = 0.75 * printed + 1e-3 * step;
  for (int pass = 0; pass < 2; ++pass) {
    double n = 0, sk = 0, skk = 0, sv = 0, skv = 0, last = u.front(), index = 0;
    for (const double v : u) {
      const double steps = std::round((v - last) / fit.step);
      if (std::abs(v - last - steps * fit.step) > 2.0 * tolerance) continue;
      index += steps;
      last = v;
      n += 1, sk += index, skk += index * index, sv += v - u.front(), skv += index * (v - u.front());
    }
    const double det = n * skk - sk * sk;
    if (!(det > 0)) return {};
    fit.step = (n * skv - sk * sv) / det;
    fit.origin = u.front() + (sv - fit.step * sk) / n;
    fit.step_sd = printed / std::sqrt(12.0) * std::sqrt(n / det);
  }
  for (const double v : u) {
    const double k = std::round((v - fit.origin) / fit.step);
    if (std::abs(v - fit.origin - k * fit.step) <= tolerance) ++fit.inliers;
  }
  return fit;
}

/// A still sensor of coarse steps reads a handful of numbers again and again, three of them often: no continuous law
/// does, and neither does a stuck value with spikes.
bool few_levels(std::span<const double> values, const std::vector<double>& u) {
  constexpr std::size_t kMost = 12, kOften = 20, kLeastOften = 3;
  if (u.size() < kLeastOften || u.size() > kMost) return false;
  const double apart = 0.25 * (u.back() - u.front()) / static_cast<double>(u.size() - 1);
  const auto often = std::count_if(u.begin(), u.end(), [&](double level) {
    const auto near = [&](double v) { return std::abs(v - level) < apart; };
    return std::count_if(values.begin(), values.end(), near) >= static_cast<std::ptrdiff_t>(kOften);
  });
  return often >= static_cast<std::ptrdiff_t>(kLeastOften);
}

bool power_of_ten(double x) {
  const double exponent = std::log10(x);
  return std::abs(exponent - std::round(exponent)) < 1e-6;
}

}  // namespace

double printing_step(std::span<const double> values) {
  double largest = 0.0;
  for (const double v : values)
    if (std::isfinite(v)) largest = std::max(largest, std::abs(v));
  double best = 1e-12 * std::max(largest, 1e-300);
  for (const double unit : kUnits) {
    for (int decimals = 0; decimals <= 11; ++decimals) {
      const double scale = std::pow(10.0, decimals) / unit;
      const bool all = std::all_of(values.begin(), values.end(), [scale](double v) {
        return !std::isfinite(v) || std::abs(v * scale - std::round(v * scale)) < 1e-6 + 1e-14 * std::abs(v * scale);
      });
      if (!all) continue;
      best = std::max(best, 1.0 / scale);
      break;
    }
  }
  return best;
}

Lattice find_lattice(std::span<const double> values, double printed_step) {
  const auto u = distinct_values(values, 0.5 * printed_step);
  const bool few = few_levels(values, u);
  if (u.size() < 4 && !few) return {};
  std::vector<double> differences(u.size() - 1);
  for (std::size_t i = 0; i + 1 < u.size(); ++i) differences[i] = u[i + 1] - u[i];
  std::sort(differences.begin(), differences.end());
  const double smallest = differences[differences.size() / 200];
  const double largest = std::max(std::abs(u.front()), std::abs(u.back()));
  for (int divisor = 1; divisor <= 4; ++divisor) {  // the smallest difference seen may be a few steps
    const double guess = smallest / divisor;
    if (guess < kLeastStepOverPrinted * printed_step || guess < kFloat32Relative * largest) return {};
    const LineFit fit = fit_lattice(u, sharpen(differences, guess, printed_step), printed_step);
    if (fit.inliers == 0) continue;
    const double chance = std::min(1.0, 1.5 * printed_step / fit.step + 2e-3);
    const bool evident = few || -static_cast<double>(u.size()) * std::log(chance) > kLeastEvidence_nats;
    if (!evident || static_cast<double>(fit.inliers) < kLeastShare * static_cast<double>(u.size())) continue;
    Lattice found{.step = fit.step, .step_sd = fit.step_sd, .origin = fit.origin};
    for (const double unit : kUnits) found.decimal = found.decimal || power_of_ten(fit.step / unit);
    return found;
  }
  return {};
}

}  // namespace stillpoint::diag
