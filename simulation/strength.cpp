#include "simulation/strength.h"

#include <Eigen/Cholesky>
#include <cmath>

namespace stillpoint::sim {
namespace {

/// Sums of the change and of its regression on 1 and the true vector: a change of B and of H.
struct Sums {
  Eigen::Matrix4d gram = Eigen::Matrix4d::Zero();
  Eigen::Matrix<double, 4, 3> cross = Eigen::Matrix<double, 4, 3>::Zero();
  Vec3 square = Vec3::Zero();
  double samples = 0.0;

  void add(const Vec3& change, const Vec3& truth) {
    const Eigen::Vector4d x(1.0, truth.x(), truth.y(), truth.z());
    gram += x * x.transpose();
    cross += x * change.transpose();
    square += change.cwiseAbs2();
    samples += 1.0;
  }

  [[nodiscard]] Strength over(const Vec3& noise_sd) const {
    Strength out;
    if (samples == 0.0 || noise_sd.minCoeff() <= 0.0) return out;
    const Eigen::Matrix<double, 4, 3> fit = gram.ldlt().solve(cross);
    double rms2 = 0.0, left = 0.0;
    for (int i = 0; i < 3; ++i) {
      const double variance = noise_sd[i] * noise_sd[i];
      rms2 += square[i] / samples / variance / 3.0;
      left += std::max(0.0, square[i] - cross.col(i).dot(fit.col(i))) / variance;
    }
    out.rms_over_noise = std::sqrt(rms2);
    out.d_prime = std::sqrt(left);
    return out;
  }
};

Vec3 noise_of(const std::optional<TriadConfig>& c) { return c ? Vec3(c->noise_sd * c->noise_axes) : Vec3::Zero(); }

}  // namespace

std::vector<EffectStrength> effect_strengths(const SimulationConfig& config,
                                             const std::shared_ptr<const Motion>& motion, std::uint64_t seed,
                                             const RecordedEnvironment& recorded) {
  const Vec3 noise[] = {noise_of(config.accelerometer), noise_of(config.gyroscope), noise_of(config.magnetometer)};
  std::vector<EffectStrength> out;
  for (std::size_t k = 0; k < config.effects.size(); ++k) {
    SimulationConfig without = config;
    without.effects.erase(without.effects.begin() + static_cast<std::ptrdiff_t>(k));
    Simulator full(config, motion, seed, recorded), twin(without, motion, seed, recorded);
    std::array<Sums, 3> sums;
    for (SimulatedSample a, b; full.next(a) && twin.next(b);) {
      const auto add = [&](Sensor s, SamplePart part, const Array3& with, const Array3& plain, const Array3& truth) {
        if (!a.sample.holds(part) || !b.sample.holds(part)) return;
        sums[static_cast<std::size_t>(s)].add(full.corrected(s, with) - full.corrected(s, plain), vec(truth));
      };
      add(Sensor::kAcc, kAcc, a.sample.acc_mps2, b.sample.acc_mps2, a.true_acc_mps2);
      add(Sensor::kGyr, kGyr, a.sample.gyr_radps, b.sample.gyr_radps, a.true_gyr_radps);
      add(Sensor::kMag, kMag, a.sample.mag_uT, b.sample.mag_uT, a.true_mag_uT);
    }
    EffectStrength& strength = out.emplace_back();
    strength.effect = config.effects[k].id;
    for (std::size_t i = 0; i < 3; ++i) strength.sensor[i] = sums[i].over(noise[i]);
  }
  return out;
}

}  // namespace stillpoint::sim
