// The attitude filter alone, on readings that are calibrated already: a body that turns about the vertical at
// 0.1 rad/s for ten seconds. Needs Stillpoint::fusion.
#include <stillpoint/fusion/attitude_filter.h>

#include <cmath>
#include <cstdio>

int main() {
  stillpoint::fusion::AttitudeFilter filter;
  stillpoint::CalibratedSample sample;
  sample.has = stillpoint::kAcc | stillpoint::kGyr;
  sample.acc_mps2 = {0, 0, 9.80665};
  sample.gyr_radps = {0, 0, 0.1};
  stillpoint::fusion::AttitudeEstimate estimate;
  for (int i = 0; i <= 1000; ++i) {
    sample.t_ns = i * 10'000'000LL;
    estimate = filter.step(sample, /*at_rest=*/false);
  }
  const auto& [w, x, y, z] = estimate.q_world_body;
  std::printf("yaw %.1f deg, standard deviation %.1f deg\n", 114.592 * std::atan2(z, w),
              57.296 * estimate.sigma_yaw_rad);
}
