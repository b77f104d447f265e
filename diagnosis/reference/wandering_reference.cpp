#include "diagnosis/reference/wandering_reference.h"

#include <cmath>
#include <numbers>

#include "core/cross_rows.h"
#include "diagnosis/reference/columns.h"

namespace stillpoint::diag {
namespace {

constexpr int kHarmonics = 8;   // of the recording's length: turns of more than 15 s a minute
constexpr int kMostTurns = 24;  // where it was seen to wander: what was not seen of it is still there
// Of what it leaves over, where a law does a tenth of its most: laws that were there had a fortieth of it or more,
// those that were not an eightieth at most.
constexpr double kTrace = 0.016, kTenthOfItsMost = 0.01;  // the latter of the power
constexpr double kWanders_rad = 3e-3;  // cameras keep their calibration to half a milliradian, markers on skin do not

/// phi(t) x v, phi a sum of cosines over the recording; its mean is a wrong matrix.
Columns slow_turns(const Signals& s, Sensor sensor) {
  Columns out;
  const Series3& v = s.vector[sensor];
  const int harmonics = s.reference_wanders ? kMostTurns : kHarmonics;
  for (int axis = 0; axis < 3; ++axis) {
    const Series3 turned = cross_rows(Series3(Vec3::Unit(axis).transpose().replicate(s.n, 1)), v);
    for (int k = 1; k <= harmonics; ++k) {
      const Series course = (s.t_s.array() * (k * std::numbers::pi / s.duration_s())).cos();
      out.push_back({-1, course.asDiagonal() * turned});
    }
  }
  return out;
}

/// Another constant field than the configured one is no physics; what moves with the body may look like it.
Columns another_field(const Signals& s, const SensorSearch& search, const Found& law) {
  return search.sensor == kMag && law.kind != Kind::kConfiguration ? world_fixed(s) : Columns{};
}

}  // namespace

bool stands_beside_wandering(const Signals& s, const SensorSearch& search, const Found& law) {
  if (s.exact_reference || law.offset.size()) return true;
  const Columns without =
      joined(search.explained(), joined(another_field(s, search, law), slow_turns(s, search.sensor)));
  const Target t = search.beside_walk();
  const double gain =
      fit_profile(t, joined(without, law.columns)).log_likelihood - fit_profile(t, without).log_likelihood;
  return gain > charge(law.names.size(), law.window) + kLeastNetBeside;
}

bool walks_beside_wandering(const Signals& s, const SensorSearch& search, double least_nats) {
  const Columns turns = joined(search.explained(), slow_turns(s, search.sensor));
  return fit_profile(search.beside_walk(), turns).log_likelihood >
         fit_profile(search.target, turns).log_likelihood + least_nats;
}

bool as_small_as_wandering(const Signals& s, const SensorSearch& search, const Found& law, const Fit& beside) {
  if (s.exact_reference || law.offset.size()) return false;
  return beyond_matrix(search, effect_of(law, beside)).norm() < kWanders_rad * s.vector[search.sensor].norm();
}

bool is_a_trace_of_the_cameras(const Signals& s, const SensorSearch& search, const Found& law, const Fit& beside) {
  if (s.exact_reference || s.from_log || !is_unknown(law.id) || law.offset.size()) return false;
  const Eigen::ArrayXd& counts = search.target.layout.counts;  // where it is lost, the reference leaves anything over
  const Series3 alone = effect_of(law, beside), effect = beyond_matrix(search, alone);
  const Eigen::ArrayXd power = alone.rowwise().squaredNorm().array() * counts;
  const Series acts = (power > kTenthOfItsMost * power.maxCoeff()).cast<double>() * counts;
  return effect.norm() < kTrace * (acts.asDiagonal() * beside.leftover).norm();
}

}  // namespace stillpoint::diag
