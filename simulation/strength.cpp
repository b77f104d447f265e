#include "simulation/strength.h"

#include <Eigen/Cholesky>
#include <cmath>

#include "simulation/whitening.h"

namespace stillpoint::sim {
namespace {

/// One axis: its whitener, and the sums of the whitened change and of its regression on 1 and the true vector, which
/// is a change of B and of H.
struct Axis {
  double noise_sd;
  Whitener whitener;
  Eigen::Matrix4d gram = Eigen::Matrix4d::Zero();
  Eigen::Vector4d cross = Eigen::Vector4d::Zero();
  double square = 0.0, plain_square = 0.0;

  Axis(const TriadConfig& c, int axis, double step_s)
      : noise_sd(c.noise_sd * c.noise_axes[axis]), whitener(noise_model(c, axis, step_s)) {}

  void add(double change, const Vec3& truth) {
    Whitener::Row row;
    row << change, 1.0, truth.transpose();
    const Whitener::Row white = whitener.whiten(row);
    const Eigen::Vector4d x = white.tail<4>().transpose();
    gram += x * x.transpose();
    cross += white[0] * x;
    square += white[0] * white[0];
    plain_square += change * change;
  }

  /// Square of the whitened change outside the span of its regressors, these scaled to unit length.
  [[nodiscard]] double outside() const {
    const Eigen::Vector4d scale = gram.diagonal().array().max(1e-300).rsqrt();
    const Eigen::Matrix4d scaled = scale.asDiagonal() * gram * scale.asDiagonal();
    const Eigen::Vector4d b = scale.asDiagonal() * cross;
    return std::max(0.0, square - b.dot(scaled.ldlt().solve(b)));
  }
};

/// The three axes of one sensor.
struct Sums {
  std::vector<Axis> axes;
  double samples = 0.0;

  Sums(const std::optional<TriadConfig>& c, double step_s) {
    if (c && c->noise_sd > 0.0 && c->noise_axes.minCoeff() > 0.0)
      for (int i = 0; i < 3; ++i) axes.emplace_back(*c, i, step_s);
  }

  void add(const Array3& with, const Array3& without, const Array3& truth) {
    for (std::size_t i = 0; i < axes.size(); ++i) axes[i].add(with[i] - without[i], vec(truth));
    samples += 1.0;
  }
  void advance() {
    for (auto& a : axes) a.whitener.advance();
  }
  [[nodiscard]] Strength strength() const {
    if (samples == 0.0) return {};
    double square = 0.0, outside = 0.0;
    for (const auto& a : axes) {
      square += a.plain_square / samples / (a.noise_sd * a.noise_sd) / 3.0;
      outside += a.outside();
    }
    return {std::sqrt(square), std::sqrt(outside)};
  }
};

EffectStrength strength_of(std::size_t effect, const SimulationConfig& config,
                           const std::shared_ptr<const Motion>& motion, std::uint64_t seed,
                           const RecordedEnvironment& recorded) {
  SimulationConfig without = config;
  without.effects[effect].window_s = {1.0, 0.0};  // never; erased, it would pass its random numbers on to the next
  Simulator full(config, motion, seed, recorded), twin(without, motion, seed, recorded);
  const double step_s = 1.0 / config.rate_hz;
  std::array<Sums, 3> sums{{{config.accelerometer, step_s}, {config.gyroscope, step_s}, {config.magnetometer, step_s}}};
  std::uint64_t row = 0;
  for (SimulatedSample a, b; full.next(a) && twin.next(b);) {
    for (; row < a.sample.sequence; ++row)  // the noise goes on through rows that were lost
      for (auto& s : sums) s.advance();
    const auto add = [&](std::size_t sensor, SamplePart part, const Array3& with, const Array3& plain,
                         const Array3& truth) {
      if (a.sample.holds(part) && b.sample.holds(part)) sums[sensor].add(with, plain, truth);
    };
    add(0, kAcc, a.sample.acc_mps2, b.sample.acc_mps2, a.true_acc_mps2);
    add(1, kGyr, a.sample.gyr_radps, b.sample.gyr_radps, a.true_gyr_radps);
    add(2, kMag, a.sample.mag_uT, b.sample.mag_uT, a.true_mag_uT);
  }
  EffectStrength out{config.effects[effect].id, {}};
  for (std::size_t i = 0; i < 3; ++i) out.sensor[i] = sums[i].strength();
  return out;
}

}  // namespace

std::vector<EffectStrength> effect_strengths(const SimulationConfig& config,
                                             const std::shared_ptr<const Motion>& motion, std::uint64_t seed,
                                             const RecordedEnvironment& recorded) {
  std::vector<EffectStrength> out;
  for (std::size_t k = 0; k < config.effects.size(); ++k) out.push_back(strength_of(k, config, motion, seed, recorded));
  return out;
}

}  // namespace stillpoint::sim
