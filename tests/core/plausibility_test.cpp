#include "core/plausibility.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

#include "core/units.h"

namespace stillpoint {
namespace {

/// A hand-held sensor: rests of 3 s, then turns about changing axes. 100 Hz, with the noise of a consumer part.
class Hand {
 public:
  RawSample next() {
    const double t = 0.01 * static_cast<double>(k_);
    RawSample s;
    s.t_ns = 10'000'000LL * k_++;
    const bool moving = std::fmod(t, 6.0) > 3.0;
    const double phase = std::numbers::pi * (std::fmod(t, 6.0) - 3.0) / 3.0;
    const Vec3 rate = moving ? Vec3(0.9 * std::sin(phase), 0.5 * std::sin(2 * phase), 0.3) : Vec3::Zero();
    const Quat turn(Eigen::AngleAxisd(0.01 * rate.norm(), rate.norm() > 0 ? rate.normalized() : Vec3::UnitX()));
    attitude_ = (attitude_ * turn).normalized();
    s.gyr_radps = array(Vec3(rate + Vec3(0.01, -0.02, 0.005) + 0.002 * noise()));
    s.acc_mps2 = array(Vec3(attitude_.conjugate() * Vec3(0, 0, kStandardGravity_mps2) + 0.03 * noise()));
    s.mag_uT = array(Vec3(attitude_.conjugate() * Vec3(0, 20, -43) + 0.3 * noise()));
    s.temp_degC = 25.0 + 0.01 * noise().x();
    s.has = kAcc | kGyr | kMag | kTemp;
    return s;
  }

 private:
  Vec3 noise() { return {normal_(random_), normal_(random_), normal_(random_)}; }
  std::int64_t k_ = 0;
  Quat attitude_ = Quat::Identity();
  std::mt19937 random_{7};
  std::normal_distribution<double> normal_;
};

/// What is found within so many seconds when every sample is spoilt like this.
std::vector<Finding> findings(double seconds, const std::function<void(RawSample&)>& spoil) {
  Hand hand;
  PlausibilityCheck check;
  for (int k = 0; k < static_cast<int>(100 * seconds); ++k) {
    RawSample s = hand.next();
    spoil(s);
    check.push(s);
  }
  return {check.findings().begin(), check.findings().end()};
}

void scale(Array3& v, double factor) {
  for (double& x : v) x *= factor;
}

TEST(Plausibility, NothingIsFoundWhereNothingIsWrong) {
  EXPECT_TRUE(findings(300.0, [](RawSample&) {}).empty());
}

struct Wrong {
  const char* name;
  Oddity oddity;
  Mistake mistake;
  std::function<void(RawSample&)> spoil;
};

TEST(Plausibility, AWrongUnitIsNamedWithinTenSeconds) {
  const Wrong all[] = {
      {"g as m/s^2", Oddity::kAccScale, Mistake::kGAsMps2, [](RawSample& s) { scale(s.acc_mps2, 1 / 9.80665); }},
      {"m/s^2 as g", Oddity::kAccScale, Mistake::kMps2AsG, [](RawSample& s) { scale(s.acc_mps2, 9.80665); }},
      {"counts", Oddity::kAccScale, Mistake::kCounts, [](RawSample& s) { scale(s.acc_mps2, 1670.0); }},
      {"range", Oddity::kAccScale, Mistake::kRange, [](RawSample& s) { scale(s.acc_mps2, 2.0); }},
      {"deg/s as rad/s", Oddity::kGyrScale, Mistake::kDegpsAsRadps,
       [](RawSample& s) { scale(s.gyr_radps, kDegPerRad); }},
      {"gauss as uT", Oddity::kMagScale, Mistake::kGaussAsUT, [](RawSample& s) { scale(s.mag_uT, 0.01); }},
      {"tesla as uT", Oddity::kMagScale, Mistake::kTeslaAsUT, [](RawSample& s) { scale(s.mag_uT, 1e-6); }},
      {"nT as uT", Oddity::kMagScale, Mistake::kNanoTeslaAsUT, [](RawSample& s) { scale(s.mag_uT, 1e3); }},
      {"ms as s", Oddity::kTimeScale, Mistake::kMsAsS, [](RawSample& s) { s.t_ns *= 1000; }},
      {"s as ms", Oddity::kTimeScale, Mistake::kSAsMs, [](RawSample& s) { s.t_ns /= 1000; }},
      {"kelvin", Oddity::kTempScale, Mistake::kKelvinAsDegC, [](RawSample& s) { s.temp_degC += 273.15; }},
      {"dead temperature", Oddity::kTempDead, Mistake::kNone, [](RawSample& s) { s.temp_degC = 0.0; }}};
  for (const Wrong& wrong : all) {
    const auto found = findings(10.0, wrong.spoil);
    ASSERT_FALSE(found.empty()) << wrong.name;
    EXPECT_EQ(found[0].oddity, wrong.oddity) << wrong.name;
    EXPECT_EQ(found[0].mistake, wrong.mistake) << wrong.name;
    EXPECT_EQ(found.size(), 1U) << wrong.name;
  }
}

TEST(Plausibility, RadiansTakenForDegreesShowWhenGravityTurnsAndTheGyroscopeDoesNot) {
  const auto found = findings(20.0, [](RawSample& s) { scale(s.gyr_radps, kRadPerDeg); });
  ASSERT_FALSE(found.empty());
  EXPECT_EQ(found[0].mistake, Mistake::kRadpsAsDegps);
}

TEST(Plausibility, ASensorAtRestThatGivesDegreesIsFoundByItsOffset) {
  PlausibilityCheck check;
  std::mt19937 random(3);
  std::normal_distribution<double> noise;
  for (int k = 0; k < 1000; ++k) {
    RawSample s;
    s.t_ns = 10'000'000LL * k;
    s.has = kAcc | kGyr;
    s.acc_mps2 = {0.03 * noise(random), 0.03 * noise(random), 9.8 + 0.03 * noise(random)};
    s.gyr_radps = {3.6 + 0.1 * noise(random), 0.02, 0.1};  // deg/s
    check.push(s);
  }
  ASSERT_EQ(check.findings().size(), 1U);
  EXPECT_EQ(check.findings()[0].mistake, Mistake::kDegpsAsRadps);
}

TEST(Plausibility, ATurntableAndACircleAreNoMistakeOfUnits) {
  for (const double radius_m : {0.0, 0.5}) {
    PlausibilityCheck check;
    std::mt19937 random(3);
    std::normal_distribution<double> noise;
    for (int k = 0; k < 6000; ++k) {
      RawSample s;
      s.t_ns = 10'000'000LL * k;
      s.has = kAcc | kGyr;
      const double rate = 3.5;
      s.acc_mps2 = {radius_m * rate * rate + 0.03 * noise(random), 0.03 * noise(random), 9.8 + 0.03 * noise(random)};
      s.gyr_radps = {0.1 + 0.002 * noise(random), 0.0, rate + 0.002 * noise(random)};
      check.push(s);
    }
    EXPECT_TRUE(check.findings().empty()) << radius_m;
  }
}

TEST(Plausibility, RepeatsAndClocksThatDoNotRunAreNamed) {
  RawSample held;
  int k = 0;
  auto found = findings(10.0, [&](RawSample& s) {
    if (k++ % 2 == 1) s.acc_mps2 = held.acc_mps2, s.gyr_radps = held.gyr_radps;
    held = s;
  });
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].oddity, Oddity::kRepeated);
  EXPECT_NEAR(found[0].value, 0.5, 0.02);

  found = findings(10.0, [](RawSample& s) { s.t_ns = std::min<std::int64_t>(s.t_ns, 2'000'000'000); });
  ASSERT_FALSE(found.empty());
  EXPECT_EQ(found[0].oddity, Oddity::kTimeStopped);

  found = findings(10.0, [](RawSample& s) { s.t_ns -= s.t_ns > 5'000'000'000 ? 3'000'000'000 : 0; });
  ASSERT_FALSE(found.empty());
  EXPECT_EQ(found[0].oddity, Oddity::kTimeBackward);

  found = findings(10.0, [](RawSample& s) { s.t_ns += s.t_ns > 5'000'000'000 ? 86'400'000'000'000 : 0; });
  ASSERT_FALSE(found.empty());
  EXPECT_EQ(found[0].oddity, Oddity::kTimeJumped);
}

/// Ten a second is the slowest that is supported; a little jitter around it is no fault.
TEST(Plausibility, AGyroscopeBelowTenReadingsASecondIsTooSlow) {
  const auto thinned_to = [](int every) {
    int k = 0;
    return findings(60.0, [&](RawSample& s) { s.has = k++ % every == 0 ? s.has : std::uint8_t{kAcc}; });
  };
  EXPECT_TRUE(thinned_to(10).empty());
  const auto found = thinned_to(12);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].oddity, Oddity::kTooSlow);
  EXPECT_NEAR(found[0].value, 0.12, 0.005);
  EXPECT_TRUE(is_too_slow(found[0]));
  EXPECT_LT(found[0].t_ns, 2'000'000'000);
}

TEST(Plausibility, NoNumberAtAllBreaksIt) {
  PlausibilityCheck check;
  std::mt19937_64 random(5);
  for (int k = 0; k < 20'000; ++k) {
    RawSample s;
    s.t_ns = static_cast<std::int64_t>(random()) / 2;
    s.has = static_cast<std::uint8_t>(random() & 15U);
    for (Array3* v : {&s.acc_mps2, &s.gyr_radps, &s.mag_uT})
      for (double& x : *v) x = std::bit_cast<double>(random());
    s.temp_degC = std::bit_cast<double>(random());
    check.push(s);
  }
  EXPECT_LE(check.findings().size(), kOddities);
}

}  // namespace
}  // namespace stillpoint
