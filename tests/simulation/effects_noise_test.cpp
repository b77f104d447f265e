/// Effects that are noise: their spectrum or Allan variance, their units, their independence of everything else.
#include <numeric>

#include "tests/simulation/effect_twins.h"

namespace stillpoint::sim {
namespace {

using Track = std::vector<double>;

SimulationConfig lying_still(double duration_s) {
  SimulationConfig c = base_config();
  c.motion = MotionConfig{.kind = "hand", .duration_s = duration_s, .min_rest_s = 1e5, .max_rest_s = 1e5};
  return c;
}

std::array<Track, 3> change_of(const std::string& yaml, Sensor sensor, const SimulationConfig& c) {
  const Twins twins({effect(yaml)}, c);
  std::array<Track, 3> out;
  for (std::size_t i = 0; i < twins.size(); ++i)
    for (std::size_t axis = 0; axis < 3; ++axis)
      out[axis].push_back(twins.change(sensor, i)[static_cast<Eigen::Index>(axis)]);
  return out;
}

double mean_square_step(const Track& x, std::size_t step) {
  double sum = 0.0;
  for (std::size_t i = step; i < x.size(); i += step) sum += std::pow(x[i] - x[i - step], 2);
  return sum / static_cast<double>((x.size() - 1) / step);
}

double correlation(const Track& a, const Track& b, std::size_t lag) {
  double ab = 0.0, aa = 0.0, bb = 0.0;
  for (std::size_t i = lag; i < a.size(); ++i) ab += a[i] * b[i - lag], aa += a[i] * a[i], bb += b[i] * b[i];
  return ab / std::sqrt(aa * bb);
}

Track steps_of(const Track& x) {
  Track out(x.size() - 1);
  for (std::size_t i = 1; i < x.size(); ++i) out[i - 1] = x[i] - x[i - 1];
  return out;
}

/// A random walk from zero, q = 0.003 times 1, 2 and 0.5: <(b(t + s) - b(t))^2> = q^2 s for every s, steps without
/// memory, axes without each other.
void expect_walk(const std::string& yaml, Sensor sensor) {
  const double q = 0.003;
  const auto b = change_of(yaml, sensor, lying_still(2000.0));
  constexpr std::array<double, 3> kFactor{1.0, 2.0, 0.5};
  std::array<Track, 3> steps;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    EXPECT_EQ(b[axis][0], 0.0);
    for (const std::size_t step : {1U, 10U, 100U, 1000U}) {
      const double seconds = static_cast<double>(step) / kRate_hz, n = static_cast<double>(b[axis].size() / step);
      EXPECT_NEAR(mean_square_step(b[axis], step) / (std::pow(q * kFactor[axis], 2) * seconds), 1.0,
                  4.0 * std::sqrt(2.0 / n))
          << yaml << " over " << seconds << " s";
    }
    steps[axis] = steps_of(b[axis]);
    const double sd = 1.0 / std::sqrt(static_cast<double>(steps[axis].size()));
    for (const std::size_t lag : {1U, 2U, 7U}) EXPECT_NEAR(correlation(steps[axis], steps[axis], lag), 0.0, 4.0 * sd);
  }
  const double sd = 1.0 / std::sqrt(static_cast<double>(steps[0].size()));
  EXPECT_NEAR(correlation(steps[0], steps[1], 0), 0.0, 4.0 * sd);
  EXPECT_NEAR(correlation(steps[1], steps[2], 0), 0.0, 4.0 * sd);
}

TEST(Law, AccDriftIsARandomWalk) {
  expect_walk("{effect: acc_drift, q_mps2_per_sqrts: [0.003, 0.006, 0.0015]}", Sensor::kAcc);
}
TEST(Law, GyrDriftIsARandomWalk) {
  expect_walk("{effect: gyr_drift, q_radps_per_sqrts: [0.003, 0.006, 0.0015]}", Sensor::kGyr);
}
TEST(Law, MagDriftIsARandomWalk) {
  expect_walk("{effect: mag_drift, q_uT_per_sqrts: [0.003, 0.006, 0.0015]}", Sensor::kMag);
}

/// Power in a band, by the Goertzel sums of a record cut into windowed pieces; one-sided, unit^2 / Hz.
double spectrum_at(const Track& x, double frequency_hz, std::size_t piece) {
  double sum = 0.0, window_power = 0.0;
  std::size_t pieces = 0;
  for (std::size_t i = 0; i < piece; ++i)
    window_power += std::pow(std::sin(M_PI * static_cast<double>(i) / static_cast<double>(piece)), 4);
  for (std::size_t start = 0; start + piece <= x.size(); start += piece / 2, ++pieces) {
    double re = 0.0, im = 0.0;
    for (std::size_t i = 0; i < piece; ++i) {
      const double k = static_cast<double>(i), hann = std::pow(std::sin(M_PI * k / static_cast<double>(piece)), 2);
      const double phase = 2.0 * M_PI * frequency_hz * k / kRate_hz;
      re += hann * x[start + i] * std::cos(phase);
      im += hann * x[start + i] * std::sin(phase);
    }
    sum += re * re + im * im;
  }
  return 2.0 * sum / static_cast<double>(pieces) / (kRate_hz * window_power);
}

/// S(f) = b^2 / (pi f), one-sided, which is the Allan floor 0.664 b: over two decades, and neither white (slope 0) nor
/// a random walk (slope -2). 80 pieces leave 11 % of scatter a point, the sum of processes ripples by 2 %.
TEST(Law, GyrInstabilityHasAOneOverFSpectrum) {
  const auto b = change_of("{effect: gyr_instability, b_radps: [1e-4, 2e-4, 5e-5]}", Sensor::kGyr, lying_still(4000.0));
  constexpr std::array<double, 3> kB{1e-4, 2e-4, 5e-5};
  double low = 0.0, high = 0.0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double ratio = 0.0;
    constexpr std::array<double, 5> kTones_hz{0.1, 0.3, 1.0, 3.0, 10.0};
    for (const double f : kTones_hz) ratio += spectrum_at(b[axis], f, 10000) / (kB[axis] * kB[axis] / (M_PI * f)) / 5.0;
    EXPECT_NEAR(ratio, 1.0, 4.0 * 0.11 / std::sqrt(5.0) + 0.02) << "axis " << axis;
    low += 0.1 * spectrum_at(b[axis], 0.1, 10000) / (kB[axis] * kB[axis]);
    high += 10.0 * spectrum_at(b[axis], 10.0, 10000) / (kB[axis] * kB[axis]);
  }
  EXPECT_NEAR(low / high, 1.0, 0.35);  // white noise: 0.01; a random walk: 100
}

/// Two equal first-order low-passes of band f_c: correlation at lag k is a^k (1 + k (1 - a^2) / (1 + a^2)) with
/// a = exp(-2 pi f_c / f_s); the standard deviations are those asked for, and there is no mean.
TEST(Law, RefErrorHasItsSizeAndItsBand) {
  SimulationConfig c = lying_still(600.0);
  const Twins twins({effect("{effect: ref_error, orientation_sd_rad: 0.002, position_sd_m: 3e-4, band_hz: 6}")}, c);
  const double a = std::exp(-2.0 * M_PI * 6.0 / kRate_hz);
  for (int axis = 0; axis < 3; ++axis) {
    Track turn, shift;
    for (std::size_t i = 0; i < twins.size(); ++i) {
      const auto &on = twins.on[i], &off = twins.off[i];
      turn.push_back(log_quat(off.ref_q_world_body.conjugate() * on.ref_q_world_body)[axis]);
      shift.push_back((on.ref_position_m - off.ref_position_m)[axis]);
      ASSERT_EQ(on.sample.acc_mps2, off.sample.acc_mps2);  // an error of the reference is none of the sensor
    }
    for (const auto& [x, sd] : {std::pair{&turn, 0.002}, std::pair{&shift, 3e-4}}) {
      // 60000 rows, about 5 of them correlated: 0.6 % on the standard deviation, four of these.
      const double n = static_cast<double>(x->size());
      const double rms = std::sqrt(std::inner_product(x->begin(), x->end(), x->begin(), 0.0) / n);
      EXPECT_NEAR(rms / sd, 1.0, 0.025);
      EXPECT_NEAR(std::accumulate(x->begin(), x->end(), 0.0) / n / sd, 0.0, 0.04);
      for (const std::size_t lag : {1U, 2U, 4U, 8U}) {
        const double k = static_cast<double>(lag);
        EXPECT_NEAR(correlation(*x, *x, lag), std::pow(a, k) * (1.0 + k * (1.0 - a * a) / (1.0 + a * a)), 0.04);
      }
    }
  }
}

/// What a second entry of the same effect adds is as large as what the first adds, and has nothing to do with it.
TEST(Law, EachEntryHasRandomNumbersOfItsOwn) {
  for (const char* yaml :
       {"{effect: acc_drift, q_mps2_per_sqrts: [1, 1, 1]}", "{effect: gyr_drift, q_radps_per_sqrts: [1, 1, 1]}",
        "{effect: mag_drift, q_uT_per_sqrts: [1, 1, 1]}", "{effect: gyr_instability, b_radps: [1, 1, 1]}",
        "{effect: sys_jitter, sd_s: 1.0e-4}", "{effect: sys_dup, fraction: 0.1}"}) {
    const EffectConfig e = effect(yaml);
    const Twins first({e}), both({e, e});
    double own = 0.0, added = 0.0, common = 0.0;
    std::array<Vec3, 6> last{};
    for (std::size_t i = 0; i < first.size(); ++i) {
      const std::array<Vec3, 6> now{first.acc(i), first.gyr(i), first.mag(i), both.acc(i), both.gyr(i), both.mag(i)};
      for (std::size_t k = 0; k < 3 && i > 0; ++k) {
        const Vec3 a = now[k] - last[k], b = now[k + 3] - last[k + 3] - a;
        own += a.squaredNorm();
        added += b.squaredNorm();
        common += a.dot(b);
      }
      last = now;
    }
    EXPECT_NEAR(std::sqrt(added / own), 1.0, 0.3) << yaml;
    EXPECT_LT(std::abs(common) / std::sqrt(own * added), 0.3) << yaml;
  }
}

}  // namespace
}  // namespace stillpoint::sim
