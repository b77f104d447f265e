#include "diagnosis/reference/unrecorded.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>

namespace stillpoint::diag {
namespace {

constexpr double kShortestPeriod_s = 4.0;  // of the unknown function: loads are switched within seconds
constexpr std::size_t kFullMatrix = 9;

/// The noise that is left beside the law and a wholly free slow function of time. Beside either of them alone an
/// autoregression takes what that one misses for its own memory.
NoiseModel noise_beside_both(const Target& plain, const Columns& columns, const Eigen::MatrixXd& slow) {
  Target free = plain;
  free.nuisance.conservativeResize(Eigen::NoChange, plain.nuisance.cols() + slow.cols());
  free.nuisance.rightCols(slow.cols()) = slow;
  return {plain.layout, fit_profile(free, columns).leftover};
}

/// What the law does to the reading, on the one line in the body along which it does most, a reading's noise being the
/// measure.
Column along_one_line(const Columns& law, const Eigen::VectorXd& theta, const NoiseModel& noise, Eigen::Index n) {
  const Vec3 sd(noise.innovation_sd(0), noise.innovation_sd(1), noise.innovation_sd(2));
  const Series3 scaled = contribution_of(law, theta, n) * sd.cwiseInverse().asDiagonal();
  const Series3 moving = scaled.rowwise() - scaled.colwise().mean();
  const Mat3 power = moving.transpose() * moving;
  const Vec3 line = Eigen::SelfAdjointEigenSolver<Mat3>(power).eigenvectors().col(2);
  return {-1, scaled * line * line.transpose() * sd.asDiagonal()};
}

Found unrecorded_scalar(Found law, const char* column) {
  law.equation =
      fmt::format("delta = k u(t), along one line in the body; written here as {}: {}", law.id, law.equation);
  law.driver = fmt::format("something that is not in the recording, such as {}; or {}", column, law.driver);
  law.id = kUnrecordedScalar;
  law.kind = Kind::kUnknown;
  return law;
}

}  // namespace

std::optional<Found> against_the_unrecorded(const Signals& s, const SensorSearch& search, const Judge& judge,
                                            Found law) {
  if (law.kind == Kind::kUnknown || law.kind == Kind::kConfiguration) return law;
  const Target& null = judge.without_walk();
  Target plain = null;  // with the law's own shift taken out, where it has one
  if (law.offset.size()) plain.residual -= law.offset;
  const Columns explained = search.explained();
  const Columns with = law.offset.size() ? explained : joined(explained, law.columns);
  const WalkBasis slow = walk_basis(s, kShortestPeriod_s);
  const NoiseModel noise = noise_beside_both(plain, with, *slow);
  const auto drifting = [&](Target t, const Columns& columns) {
    t.walk = slow;
    return fit_walking(t, columns, noise).log_likelihood;
  };
  const Fit alone = fit_with(plain, with, noise, {});
  const double both = drifting(plain, with);
  const double beside_drift = both - drifting(null, explained), of_drift = both - alone.log_likelihood;
  if (of_drift > beside_drift && beside_drift < charge(law.names.size(), law.window) + kLeastNetBeside)
    return std::nullopt;

  const Series& scalar = search.sensor == kMag ? s.current_A : s.voltage_V;
  if (scalar.size() || law.columns.size() != kFullMatrix) return law;
  const Column line =
      along_one_line(law.columns, alone.theta.tail(static_cast<Eigen::Index>(kFullMatrix)), noise, plain.layout.n);
  const double one = fit_with(plain, joined(explained, {line}), noise, {}).log_likelihood;
  if (alone.log_likelihood - one > tie_nats(law.window)) return law;
  return unrecorded_scalar(std::move(law), search.sensor == kMag ? "current_A" : "supply_V");
}

}  // namespace stillpoint::diag
