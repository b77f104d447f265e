/// Rest rules compared: how many usable windows each keeps when it lets 5 % of the unusable ones pass.
#include <algorithm>
#include <array>
#include <cstdio>
#include <utility>

#include "bench/calibration_rest_rules.h"
#include "bench/calibration_tables.h"
#include "calib_online/rest_detector.h"

namespace stillpoint::bench {
namespace {

constexpr double kRate_hz = 100.0;
constexpr double kUsable_mps2 = 0.03;  // 3 mg of linear acceleration left: what a calibration to 1 mg can bear

struct Case {
  std::vector<MotionSample> samples;
  double error_mps2 = 0.0;  ///< linear acceleration that the de-rotated mean still holds
};

/// Two seconds of wear: sway with the sensor on a lever arm, harmless vibration, and pushes.
Case draw(Random& random) {
  Case c;
  const Quat start = random.rotation();
  const double sway_rate = std::exp(random.uniform(std::log(0.001), std::log(0.3)));  // rad/s
  const double sway_hz = random.uniform(0.05, 1.0), sway_phase = random.uniform(0, 6.28);
  const Vec3 sway_axis = random.direction(), lever = random.direction() * random.uniform(0.0, 0.5);
  const double shake = std::exp(random.uniform(std::log(0.005), std::log(1.0))), shake_hz = random.uniform(6, 40);
  const Vec3 shake_axis = random.direction(), push_axis = random.direction();
  // A body that sways moves 0.1 mm to 10 cm: a slow push is a weak one.
  const double push_hz = random.uniform(0.05, 1.5),
               push = std::exp(random.uniform(std::log(1e-4), std::log(0.1))) * std::pow(6.2832 * push_hz, 2),
               push_phase = random.uniform(0, 6.28);
  Quat q = start;
  Vec3 truth = Vec3::Zero();
  const int n = 200;
  std::vector<Vec3> f;
  std::vector<Quat> attitude;
  for (int k = 0; k < n; ++k) {
    const double t = k / kRate_hz;
    const Vec3 w = sway_rate * std::sin(6.2832 * sway_hz * t + sway_phase) * sway_axis;
    const Vec3 dw = sway_rate * 6.2832 * sway_hz * std::cos(6.2832 * sway_hz * t + sway_phase) * sway_axis;
    const Vec3 linear = dw.cross(lever) + w.cross(w.cross(lever)) +
                        shake * std::sin(6.2832 * shake_hz * t) * shake_axis +
                        q.conjugate() * (push * std::sin(6.2832 * push_hz * t + push_phase) * push_axis);
    const Vec3 clean = q.conjugate() * Vec3(0, 0, kStandardGravity_mps2) + linear;
    c.samples.push_back({clean + random.normal3(0.02), w + random.normal3(0.001)});
    f.push_back(clean);
    attitude.push_back(q);
    q = (q * exp_quat(w / kRate_hz)).normalized();
  }
  for (int k = 0; k < n; ++k) truth += attitude[static_cast<std::size_t>(k)] * f[static_cast<std::size_t>(k)] / n;
  c.error_mps2 = (truth - Vec3(0, 0, kStandardGravity_mps2)).norm();
  return c;
}

/// The detector as the daemon runs it, on the window alone.
bool detector_keeps(const std::vector<MotionSample>& window) {
  calib::RestDetector detector;
  const CalibrationSnapshot exact;
  for (std::size_t k = 0; k <= window.size(); ++k) {  // one more sample closes the last quarter
    const auto& s = window[std::min(k, window.size() - 1)];
    RawSample raw;
    raw.t_ns = static_cast<std::int64_t>(static_cast<double>(k) / kRate_hz * kNsPerSecond);
    raw.has = kAcc | kGyr;
    raw.acc_mps2 = array(s.acc_mps2);
    raw.gyr_radps = array(s.gyr_radps);
    if (detector.push(raw, exact)) return true;
  }
  return false;
}

constexpr int kRules = 4;
constexpr std::array<const char*, kRules> kNames{"coefficient of variation, x axis", "variance, three axes",
                                                 "SHOE/GLRT", "de-rotated quarter means (default)"};
std::array<double, kRules> statistics(const std::vector<MotionSample>& window) {
  return {coefficient_of_variation(window, 500, 2300), three_axis_variance(window),
          shoe(window, kStandardGravity_mps2, 0.02, 0.001), derotated_quarters(window, 1.0 / kRate_hz)};
}

/// Percent of usable and of unusable windows that a rule with a fixed limit keeps, a seed.
struct Fixed {
  std::vector<double> kept, false_accepts;
  int good = 0, bad = 0;
  void take(bool usable, bool accepted) { (usable ? good : bad) += accepted; }
  void close(std::size_t n_good, std::size_t n_bad) {
    kept.push_back(100.0 * std::exchange(good, 0) / static_cast<double>(n_good));
    false_accepts.push_back(100.0 * std::exchange(bad, 0) / static_cast<double>(n_bad));
  }
};

double standard_error(const std::vector<double>& v) { return sd(v) / std::sqrt(static_cast<double>(v.size())); }

constexpr unsigned kFirstSeed = 31, kSeeds = 12;
constexpr int kWindows = 6000;

/// What each rule keeps, a seed: with the limit that lets 5 % of the unusable windows pass, and two limits as shipped.
struct Kept {
  std::array<std::vector<double>, kRules> percent;
  Fixed paper, detector;
  double usable_percent = 0.0;

  void add_seed(unsigned seed) {
    Random random(seed);
    std::array<std::vector<double>, kRules> good, bad;
    for (int k = 0; k < kWindows; ++k) {
      const Case c = draw(random);
      const bool usable = c.error_mps2 < kUsable_mps2;
      const auto s = statistics(c.samples);
      for (std::size_t r = 0; r < kRules; ++r) (usable ? good : bad)[r].push_back(s[r]);
      paper.take(usable, s[0] < 3e-3);
      detector.take(usable, detector_keeps(c.samples));
    }
    for (std::size_t r = 0; r < kRules; ++r) {
      const double limit = quantile(bad[r], 0.05);
      const auto n = std::count_if(good[r].begin(), good[r].end(), [limit](double v) { return v < limit; });
      percent[r].push_back(100 * static_cast<double>(n) / static_cast<double>(good[r].size()));
    }
    paper.close(good[0].size(), bad[0].size());
    detector.close(good[0].size(), bad[0].size());
    usable_percent += 100.0 * static_cast<double>(good[0].size()) / (kSeeds * kWindows);
  }
};

}  // namespace

Figures rest_detection() {
  std::printf(
      "\n== Rest rules: usable windows kept at 5 %% false accepts (+- two standard errors of the mean over seeds); "
      "%u seeds of %d windows of 2 s, 100 Hz, seeds %u..%u; usable: < 3 mg of linear acceleration left in the true "
      "mean ==\n",
      kSeeds, kWindows, kFirstSeed, kFirstSeed + kSeeds - 1);
  Kept kept;
  for (unsigned seed = kFirstSeed; seed < kFirstSeed + kSeeds; ++seed) kept.add_seed(seed);
  std::printf("usable: %.0f %% of the windows\n", kept.usable_percent);
  for (std::size_t r = 0; r < kRules; ++r)
    std::printf("  %-36s %5.1f %% +- %.1f\n", kNames[r], mean(kept.percent[r]), 2.0 * standard_error(kept.percent[r]));
  std::printf("  the paper's limit 3e-3 as printed keeps %.1f %% with %.1f %% false accepts\n", mean(kept.paper.kept),
              mean(kept.paper.false_accepts));
  std::printf("  the detector with the limits it ships keeps %.1f %% with %.1f %% false accepts\n",
              mean(kept.detector.kept), mean(kept.detector.false_accepts));
  return {{"quarters.kept_percent", mean(kept.percent[3])},
          {"quarters.standard_error", standard_error(kept.percent[3])},
          {"detector.kept_percent", mean(kept.detector.kept)},
          {"detector.false_percent", mean(kept.detector.false_accepts)},
          {"paper.kept_percent", mean(kept.percent[0])}};
}

}  // namespace stillpoint::bench
