#include <algorithm>
#include <array>
#include <cmath>

#include "core/median.h"
#include "diagnosis/no_reference/model.h"

namespace stillpoint::diag::detail {
namespace {

constexpr double kCell_s = 0.25;
constexpr double kLeastRest_s = 1.0, kLeastInAll_s = 2.0;
constexpr double kOffsetSpread_radps = 0.06;   // a mean rate this far from the offset is a slow turn
constexpr double kLargestOffset_radps = 0.35;  // 20 deg/s: no gyroscope is sold with more

struct Scatter {
  Vec3 mean = Vec3::Zero();
  double sd = 0.0;
};

Scatter scatter(const std::vector<Vec3>& v, std::size_t first, std::size_t last) {
  Scatter s;
  double n = 0;
  for (std::size_t i = first; i < last; ++i)
    if (v[i].allFinite()) s.mean += v[i], n += 1;
  if (n < 2) return {Vec3::Zero(), HUGE_VAL};
  s.mean /= n;
  for (std::size_t i = first; i < last; ++i)
    if (v[i].allFinite()) s.sd = std::max(s.sd, (v[i] - s.mean).cwiseAbs2().maxCoeff());
  s.sd = std::sqrt(s.sd);
  return s;
}

/// What the gyro reads when still: the median over the cells as quiet as the quietest. The configured offset may be
/// wrong by more than a slow turn.
Vec3 offset_of(const std::vector<Scatter>& rate, const std::vector<Scatter>& force, double rate_limit,
               double force_limit, const Vec3& configured) {
  std::array<std::vector<double>, 3> means;
  for (std::size_t c = 0; c < rate.size(); ++c)
    for (std::size_t k = 0; k < 3 && rate[c].sd <= rate_limit && force[c].sd <= force_limit; ++k)
      means[k].push_back(rate[c].mean[static_cast<long>(k)]);
  if (means[0].empty()) return configured;
  const Vec3 offset(quantile(means[0], 0.5), quantile(means[1], 0.5), quantile(means[2], 0.5));
  return (offset - configured).norm() < kLargestOffset_radps ? offset : configured;
}

}  // namespace

std::vector<RestWindow> find_rest(const io::Recording& r, const sim::SimulationConfig& simulation) {
  const auto* gyro = triad(simulation, kGyr);
  if (gyro == nullptr || r.gyr_radps.empty() || r.size() < 10) return {};
  const double step_s = std::max(r.median_step_s(), 1e-6);
  const auto n = std::max<std::size_t>(4, static_cast<std::size_t>(std::lround(kCell_s / step_s)));
  std::vector<Scatter> rate, force;
  std::vector<double> rate_sd, force_sd;
  for (std::size_t i = 0; i + n <= r.size(); i += n) {
    rate.push_back(scatter(r.gyr_radps, i, i + n));
    force.push_back(r.acc_mps2.empty() ? Scatter{} : scatter(r.acc_mps2, i, i + n));
    rate_sd.push_back(rate.back().sd), force_sd.push_back(force.back().sd);
  }
  // The quietest tenth of the recording shows the noise as it is; the configured one may be wrong.
  const double rate_limit = std::max(2.5 * quantile(rate_sd, 0.1), 4.0 * gyro->noise_sd);
  const auto* acc = triad(simulation, kAcc);
  const double force_limit = std::max(2.5 * quantile(force_sd, 0.1), acc ? 4.0 * acc->noise_sd : 0.0);
  const Vec3 offset = offset_of(rate, force, rate_limit, force_limit + 1e-12, gyro->bias);
  std::vector<RestWindow> rest;
  std::size_t run = 0;
  for (std::size_t c = 0; c <= rate.size(); ++c) {
    const bool quiet = c < rate.size() && rate[c].sd <= rate_limit && force[c].sd <= force_limit + 1e-12 &&
                       (rate[c].mean - offset).norm() < kOffsetSpread_radps;
    if (quiet) {
      ++run;
      continue;
    }
    // The cells at either end may hold the tail of the motion.
    if (run >= 3 && static_cast<double>((run - 2) * n) * step_s >= kLeastRest_s - 1e-9)
      rest.push_back({(c - run + 1) * n, (c - 1) * n - 1});
    run = 0;
  }
  double whole_s = 0.0;
  for (const RestWindow& w : rest) whole_s += r.t_s(w.last) - r.t_s(w.first);
  if (whole_s < kLeastInAll_s) rest.clear();  // what turns slowly passes through a second of it
  return rest;
}

}  // namespace stillpoint::diag::detail
