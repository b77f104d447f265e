#include "diagnosis/reference/plausible.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/reference/evidence.h"
#include "diagnosis/usual_size.h"
#include "simulation/effect_catalogue.h"

namespace stillpoint::diag {
namespace {

constexpr double kImitated = 0.25;  // of a resonance's power: what its own noise may have made
// Gravity is told from a scale by the reference's translation alone, and that has a scale of its own: a clock's rate
// twice, and of a camera a wand's length and what lines between frames take off a stroke (at 3 Hz of 100 frames a
// second a thousandth and a half).
constexpr double kTranslationScale = 3e-4, kCamerasTranslationScale = 1e-3;
constexpr double kMostOnEarth_mps2 = 0.2;

/// The catalogue's entry of a law whose numbers are coefficients; nullptr: it is another kind of law.
const sim::EffectInfo* entry_of_linear(const Found& law) {
  if (law.kind != Kind::kNamed || law.offset.size() || law.columns.empty()) return nullptr;
  return sim::find_effect(law.id);
}

/// Numbers that undo one another: together they do a trace of what each of them does, as the nine of a matrix may where
/// the field keeps to a plane. On another motion they would not.
bool undo_one_another(const Found& law, const Eigen::VectorXd& theta) {
  constexpr double kTrace = 0.01;
  const Eigen::Index n = law.columns.front().x.rows();
  double apart = 0.0;
  for (std::size_t j = 0; j < law.columns.size(); ++j)
    apart = std::max(apart, std::abs(theta[static_cast<Eigen::Index>(j)]) * law.columns[j].x.norm());
  return contribution_of(law.columns, theta, n).norm() < kTrace * apart;
}

}  // namespace

bool is_its_own_noise(const Signals& s, const SensorSearch& search, const Found& law) {
  const double band_hz = s.band_hz[search.sensor], f_n_hz = law.timing[0], sd = s.noise_sd[search.sensor];
  const auto rows = static_cast<double>((law.offset.array() != 0.0).count());
  const double of_noise = rows * sd * sd * 4.0 * s.dt_s * std::pow(band_hz, 3) / (3.0 * f_n_hz * f_n_hz);
  return of_noise > kImitated * law.offset.squaredNorm();
}

bool possible(const Signals& s, const SensorSearch& search, const Found& law) {
  if (law.id.ends_with("_resonance") && law.timing.size() == 2) {
    if (is_its_own_noise(s, search, law)) return false;
    // A damping that may as well be none is that of a line, which the reference may have brought in.
    Target t = search.target;
    t.residual -= law.offset;
    const Fit fit = fit_profile(t, joined(search.explained(), law.columns));
    const Eigen::Index last = fit.theta.size() - 1;
    return law.timing[1] > 2.0 * std::sqrt(std::max(fit.covariance(last, last), 0.0));
  }
  const auto count = static_cast<Eigen::Index>(law.columns.size());
  if (law.names == kWholeOrNothing) {
    const Fit fit = fit_beside(search, law);
    const double share = fit.theta.tail(count)[0],
                 sd = std::sqrt(std::max(fit.covariance.diagonal().tail(count)[0], 0.0));
    return is_share_of_a_whole(share) && share > 2.0 * sd;
  }
  const sim::EffectInfo* info = entry_of_linear(law);
  if (info == nullptr) return true;
  const Fit fit = fit_beside(search, law);
  if (undo_one_another(law, fit.theta.tail(count))) return false;
  if (law.id == "acc_gravity") {
    const double dg = std::abs(fit.theta.tail(count)[0]), sd = std::sqrt(fit.covariance.diagonal().tail(count)[0]);
    const double scale = s.exact_reference ? kTranslationScale : kCamerasTranslationScale;
    return dg > 2.0 * std::hypot(sd, scale * s.gravity_mps2) && dg < kMostOnEarth_mps2;
  }
  return may_be_of_a_part(*info, law.names, fit.theta.tail(count),
                          fit.covariance.diagonal().tail(count).cwiseMax(0.0).cwiseSqrt());
}

bool moves_the_others(const SensorSearch& search, const Fit& before, const Fit& beside) {
  constexpr double kSwells = 3.0;         // times what it did before
  constexpr double kAnotherMatrix = 0.1;  // by which the largest entry may grow for a law
  const auto matrix_of = [](const Fit& fit) {
    return Eigen::Map<const Eigen::Matrix<double, 4, 3>>(fit.nuisance.data()).bottomRows<3>().cwiseAbs().maxCoeff();
  };
  if (matrix_of(beside) > matrix_of(before) + kAnotherMatrix) return true;
  return std::any_of(search.found.begin(), search.found.end(), [&](const Found& f) {
    const auto first = first_column(search, static_cast<std::size_t>(&f - search.found.data()));
    const auto size = [&](const Fit& fit) {
      const Eigen::VectorXd own = fit.theta.segment(first, static_cast<Eigen::Index>(f.columns.size()));
      return contribution_of(f.columns, own, search.target.layout.n).norm();
    };
    return f.offset.size() == 0 && size(beside) > kSwells * size(before);
  });
}

bool is_of_a_filters_form(const SensorSearch& search, const Found& law) {
  constexpr double kForm = 0.005;
  Series3 filters = Series3::Zero(search.target.layout.n, 3);
  for (const Found& f : search.found)
    if (is_filter(f.id)) filters += f.offset;
  if (filters.isZero(0.0)) return false;
  const Series3 own = law.offset.size() ? law.offset : effect_of(law, fit_beside(search, law));
  const Eigen::ArrayXd acts = (own.rowwise().squaredNorm().array() > 0.0).cast<double>() * search.target.layout.counts;
  const auto power = [&](const Series3& x) { return (x.rowwise().squaredNorm().array() * acts).sum(); };
  return power(own) < kForm * kForm * power(filters);
}

double decades_below_usual(const SensorSearch& search, const Found& law) {
  if (law.id == "sys_skew") {
    const double usual = 1e-6 * sim::find_effect(law.id)->parameters.front().typical_low;
    return law.timing.size() > 1 ? 0.0 : std::max(0.0, -std::log10(std::abs(law.timing[0]) / usual));
  }
  const sim::EffectInfo* info = entry_of_linear(law);
  if (info == nullptr) return 0.0;
  const Fit fit = fit_beside(search, law);
  const auto first = fit.theta.size() - static_cast<Eigen::Index>(law.columns.size());
  double most = 0.0;  // of the usual size
  for (std::size_t j = 0; j < law.names.size() && j < law.columns.size(); ++j)
    for (const auto& p : info->parameters)
      if (law.names[j].starts_with(p.symbol) && p.typical_low > 0)
        most = std::max(most, std::abs(fit.theta[first + static_cast<Eigen::Index>(j)]) / p.typical_low);
  return most > 0 ? std::max(0.0, -std::log10(most)) : 0.0;
}

}  // namespace stillpoint::diag
