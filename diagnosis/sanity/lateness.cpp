#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "diagnosis/sanity/reference_checks.h"

namespace stillpoint::diag::detail {
namespace {

constexpr double kPiece_s = 0.02, kReach_s = 10.0;
constexpr double kPhysics_s = 0.15;  // lags up to this are physics (T1), larger ones are a mix-up

/// Sizes of the rates on a grid, zero where there are none.
struct Sizes {
  std::vector<double> gyro, reference;
  double step_s = 0.0;
};

double correlation(const Sizes& s, std::ptrdiff_t lag) {
  const auto n = static_cast<std::ptrdiff_t>(s.gyro.size());
  double gr = 0, gg = 0, rr = 0;
  for (std::ptrdiff_t i = std::max<std::ptrdiff_t>(0, -lag); i < std::min(n, n - lag); ++i) {
    const double g = s.gyro[static_cast<std::size_t>(i)], p = s.reference[static_cast<std::size_t>(i + lag)];
    gr += g * p, gg += g * g, rr += p * p;
  }
  return gg > 0 && rr > 0 ? gr / std::sqrt(gg * rr) : 0.0;
}

}  // namespace

void check_lateness(const Comparison& c, const io::Recording& r, Sanity& out) {
  const double step_s = std::max(r.median_step_s(), 1e-9);
  const auto piece =
      static_cast<std::size_t>(std::clamp(std::round(kPiece_s / step_s), 1.0, 0.1 * static_cast<double>(r.size())));
  Sizes sizes{.gyro = {}, .reference = {}, .step_s = static_cast<double>(piece) * step_s};
  for (std::size_t i = c.first(); i + c.first() + piece < r.size(); i += piece) {
    Vec3 measured = Vec3::Zero(), predicted = Vec3::Zero();
    c.rate(i, as_expected, measured, predicted);
    sizes.gyro.push_back(measured.allFinite() ? measured.norm() : 0.0);
    sizes.reference.push_back(predicted.allFinite() ? predicted.norm() : 0.0);
  }
  const auto reach = std::min(static_cast<std::ptrdiff_t>(kReach_s / sizes.step_s),
                              static_cast<std::ptrdiff_t>(sizes.gyro.size() / 4));
  const double now = correlation(sizes, 0);
  std::ptrdiff_t best = 0;
  double highest = now;
  for (std::ptrdiff_t lag = -reach; lag <= reach; ++lag)
    if (const double q = correlation(sizes, lag); q > highest) highest = q, best = lag;
  const double late_s = static_cast<double>(best) * sizes.step_s;
  if (std::abs(late_s) < kPhysics_s || highest < 0.8 || highest < now + 0.1) return;
  out.mistake(fmt::format("reference: it is {:.2f} s {} the sensors; align the clocks before comparing",
                          std::abs(late_s), late_s > 0 ? "behind" : "ahead of"));
  out.reference_unusable = true;
}

}  // namespace stillpoint::diag::detail
