/// A walk keeps its speed in every turn: what bounds the motion of a hand must not turn the world under it.
#include "core/units.h"
#include "simulation/random.h"
#include "tests/fusion/attitude_testing.h"

namespace stillpoint::fusion {
namespace {

constexpr double kRow_s = 0.01;

/// Upright, 1.4 m/s, ever turning, two steps a second; never at rest. No magnetometer.
class Walk {
 public:
  explicit Walk(unsigned seed) : random_(seed, "walk") {}
  CalibratedSample next() {
    t_s_ += kRow_s;
    turn_radps_ += kRow_s / 4.0 * -turn_radps_ + 0.35 * std::sqrt(2.0 * kRow_s / 4.0) * random_.normal3().x();
    const double step = 2.0 * kTwoPi * t_s_;
    CalibratedSample s;
    s.t_ns = std::llround(1e9 * t_s_);
    s.has = kAcc | kGyr;
    const Vec3 force(1.2 * std::sin(step), kSpeed_mps * turn_radps_ + 0.9 * std::cos(0.5 * step),
                     kStandardGravity_mps2 + 2.5 * std::cos(step));
    s.acc_mps2 = array(Vec3(force + 0.05 * random_.normal3()));
    s.gyr_radps = array(Vec3(Vec3(0.0, 0.0, turn_radps_) + gyr_bias_ + 0.002 * random_.normal3()));
    return s;
  }
  [[nodiscard]] double offset_about_up_radps() const { return gyr_bias_.z(); }

 private:
  static constexpr double kSpeed_mps = 1.4;
  sim::Stream random_;
  Vec3 gyr_bias_ = 0.01 * random_.normal3();
  double t_s_ = 0.0, turn_radps_ = 0.0;
};

/// Rms over seeds of what the filter has the offset about the vertical wrong by, after two minutes.
double wrong_radps(bool rests_first) {
  constexpr int kSeeds = 10;
  double sum2 = 0.0;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    Walk walk(seed);
    AttitudeFilter filter;
    AttitudeEstimate e;
    for (int i = 0; rests_first && i < 1000; ++i) {
      CalibratedSample s = walk.next();
      s.acc_mps2 = {0.0, 0.0, kStandardGravity_mps2};
      s.gyr_radps = {0.0, 0.0, walk.offset_about_up_radps()};
      e = filter.step(s, true);
    }
    for (int i = 0; i < 12000; ++i) e = filter.step(walk.next(), false);
    const double wrong = e.gyro_bias_radps[2] - walk.offset_about_up_radps();
    sum2 += wrong * wrong;
  }
  return std::sqrt(sum2 / kSeeds);
}

TEST(Walk, TeachesNoOffsetAboutTheVertical) { EXPECT_LT(wrong_radps(false), 0.015); }
TEST(Walk, LeavesTheOffsetThatARestHasShown) { EXPECT_LT(wrong_radps(true), 0.004); }

}  // namespace
}  // namespace stillpoint::fusion
