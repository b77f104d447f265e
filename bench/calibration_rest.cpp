/// Rest rules compared: how many usable windows each keeps when it lets 5 % of the unusable ones pass.
#include <cstdio>

#include "bench/calibration_tables.h"
#include "calib_online/rest_rules.h"

namespace stillpoint::bench {
namespace {

constexpr double kRate_hz = 100.0;
constexpr double kUsable_mps2 =
    0.03;  // 3 mg of linear acceleration left in the mean: what a calibration to 1 mg can bear

struct Case {
  std::vector<calib::MotionSample> samples;
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

}  // namespace

Figures rest_detection() {
  std::printf(
      "\n== Rest rules: usable windows kept at 5 %% false accepts; 6000 windows of 2 s, 100 Hz, seeds 31..33; usable: "
      "< 3 mg of linear acceleration left in the true mean ==\n");
  std::vector<double> kept[5], paper_kept, paper_false;
  double share = 0.0;
  for (unsigned seed = 31; seed < 34; ++seed) {
    Random random(seed);
    std::vector<double> good[5], bad[5];
    int below_good = 0, below_bad = 0;
    for (int k = 0; k < 6000; ++k) {
      const Case c = draw(random);
      const double cv = calib::coefficient_of_variation(c.samples, 500, 2300);
      const double s[5] = {cv, calib::three_axis_variance(c.samples),
                           calib::shoe(c.samples, kStandardGravity_mps2, 0.02, 0.001),
                           calib::derotated_quarters(c.samples, 1.0 / kRate_hz),
                           calib::derotated_quarters_with_gravity(c.samples, 1.0 / kRate_hz, kStandardGravity_mps2)};
      const bool usable = c.error_mps2 < kUsable_mps2;
      for (int r = 0; r < 5; ++r) (usable ? good : bad)[r].push_back(s[r]);
      (usable ? below_good : below_bad) += cv < 3e-3;
    }
    for (int r = 0; r < 5; ++r) {
      const double limit = quantile(bad[r], 0.05);
      double n = 0;
      for (double v : good[r]) n += v < limit;
      kept[r].push_back(100 * n / static_cast<double>(good[r].size()));
    }
    paper_kept.push_back(100.0 * below_good / static_cast<double>(good[0].size()));
    paper_false.push_back(100.0 * below_bad / static_cast<double>(bad[0].size()));
    share += 100.0 * static_cast<double>(good[0].size()) / 18000.0;
  }
  std::printf("usable: %.0f %% of the windows\n", share);
  const char* names[5] = {"coefficient of variation, x axis", "variance, three axes", "SHOE/GLRT",
                          "de-rotated quarter means", "the same, sensor calibrated"};
  for (int r = 0; r < 5; ++r) std::printf("  %-34s %5.1f %% +- %.1f\n", names[r], mean(kept[r]), sd(kept[r]));
  std::printf("  the paper's limit 3e-3 as printed keeps %.1f %% with %.1f %% false accepts\n", mean(paper_kept),
              mean(paper_false));
  return {{"quarters.kept_percent", mean(kept[3])},
          {"quarters_calibrated.kept_percent", mean(kept[4])},
          {"paper.kept_percent", mean(kept[0])}};
}

}  // namespace stillpoint::bench
