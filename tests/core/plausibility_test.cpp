#include "core/plausibility.h"

#include <gtest/gtest.h>

#include <algorithm>
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

/// 480 mG look like iron of 480 uT as long as nothing turns; iron turns with the body.
TEST(Plausibility, MilliGaussAsMicroTeslaIsNamedOnceTheFieldTurnsAndIronIsNot) {
  const auto found = findings(30.0, [](RawSample& s) { scale(s.mag_uT, 10.0); });
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].oddity, Oddity::kMagScale);
  EXPECT_EQ(found[0].mistake, Mistake::kMilliGaussAsUT);
  for (const double iron_uT : {150.0, 200.0, 250.0, 400.0, 600.0})
    for (std::size_t axis = 0; axis < 3; ++axis)
      EXPECT_TRUE(findings(300.0, [=](RawSample& s) { s.mag_uT[axis] += iron_uT; }).empty()) << iron_uT;
}

/// A finding stands while the sensor rests or lies still, and until its readings have been right for a while.
TEST(Plausibility, AFindingStandsUntilTheReadingsAreRight) {
  const Wrong all[] = {
      {"acc", Oddity::kAccScale, Mistake::kGAsMps2, [](RawSample& s) { scale(s.acc_mps2, 1 / 9.80665); }},
      {"gyr", Oddity::kGyrScale, Mistake::kDegpsAsRadps, [](RawSample& s) { scale(s.gyr_radps, kDegPerRad); }},
      {"gyr silent", Oddity::kGyrSilent, Mistake::kRadpsAsDegps, [](RawSample& s) { scale(s.gyr_radps, kRadPerDeg); }},
      {"mag", Oddity::kMagScale, Mistake::kGaussAsUT, [](RawSample& s) { scale(s.mag_uT, 0.01); }},
      {"mag in mG", Oddity::kMagScale, Mistake::kMilliGaussAsUT, [](RawSample& s) { scale(s.mag_uT, 10.0); }},
      {"temp", Oddity::kTempScale, Mistake::kKelvinAsDegC, [](RawSample& s) { s.temp_degC += 273.15; }},
      {"dead", Oddity::kTempDead, Mistake::kNone, [](RawSample& s) { s.temp_degC = 0.0; }}};
  for (const Wrong& wrong : all) {
    Hand hand;
    PlausibilityCheck check;
    const auto stands = [&check, &wrong] {
      const auto found = check.findings();
      return std::any_of(found.begin(), found.end(),
                         [&wrong](const Finding& f) { return f.oddity == wrong.oddity && f.stands; });
    };
    const auto push = [&](double seconds, bool spoilt) {
      int standing = 0;
      const int n = static_cast<int>(100 * seconds);
      for (int k = 0; k < n; ++k) {
        RawSample s = hand.next();
        if (spoilt) wrong.spoil(s);
        check.push(s);
        standing += stands() ? 1 : 0;
      }
      return standing == n;
    };
    push(25.0, true);
    EXPECT_TRUE(push(60.0, true)) << wrong.name << ": rests of three seconds do not lift it";
    push(25.0, false);
    EXPECT_FALSE(stands()) << wrong.name;
    push(25.0, true);
    EXPECT_TRUE(stands() || wrong.oddity == Oddity::kTempDead) << wrong.name << ": it is found again";
  }
}

TEST(Plausibility, RadiansTakenForDegreesShowWhenGravityTurnsAndTheGyroscopeDoesNot) {
  const auto found = findings(20.0, [](RawSample& s) { scale(s.gyr_radps, kRadPerDeg); });
  ASSERT_FALSE(found.empty());
  EXPECT_EQ(found[0].mistake, Mistake::kRadpsAsDegps);
}

/// What is found in `n` rows of a sensor that lies level, but for what `gyr_of(time in s, noise)` and `acc_x_of` say.
template <class Rate, class Force>
std::vector<Finding> lying_level(int n, std::int64_t period_ns, const Rate& gyr_of, const Force& acc_x_of) {
  PlausibilityCheck check;
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  const auto noise = [&] { return normal(random); };
  for (int k = 0; k < n; ++k) {
    RawSample s;
    s.t_ns = period_ns * k;
    s.has = kAcc | kGyr;
    s.acc_mps2 = {acc_x_of(in_seconds(s.t_ns)) + 0.03 * noise(), 0.03 * noise(), 9.8 + 0.03 * noise()};
    s.gyr_radps = gyr_of(in_seconds(s.t_ns), noise);
    check.push(s);
  }
  return {check.findings().begin(), check.findings().end()};
}

template <class Rate>
std::vector<Finding> lying_level(int n, std::int64_t period_ns, const Rate& gyr_of, double acc_x = 0.0) {
  return lying_level(n, period_ns, gyr_of, [acc_x](double) { return acc_x; });
}

TEST(Plausibility, ASensorAtRestThatGivesDegreesIsFoundByItsOffset) {
  const auto found = lying_level(1000, 10'000'000, [](double, auto& noise) -> Array3 {
    return {3.6 + 0.1 * noise(), 0.02, 0.1};  // deg/s
  });
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].mistake, Mistake::kDegpsAsRadps);
}

TEST(Plausibility, ATurntableAndACircleAreNoMistakeOfUnits) {
  constexpr double kRate = 3.5;
  const auto turning = [](double, auto& noise) -> Array3 {
    return {0.1 + 0.002 * noise(), 0.0, kRate + 0.002 * noise()};
  };
  for (const double radius_m : {0.0, 0.5})
    EXPECT_TRUE(lying_level(6000, 10'000'000, turning, radius_m * kRate * kRate).empty()) << radius_m;
}

/// Read 25 times a second, a hand that trembles about the vertical changes its rate from reading to reading.
TEST(Plausibility, AQuickTurnAboutTheVerticalIsNoNoiseOfASensorInDegrees) {
  const auto trembling = [](double t_s, auto& noise) -> Array3 {
    const double rate = 0.12 * std::sin(2.0 * std::numbers::pi * 4.2 * t_s);
    return {0.002 * noise(), 0.002 * noise(), rate + 0.002 * noise()};
  };
  EXPECT_TRUE(lying_level(3000, 40'000'000, trembling).empty());
}

/// A car gathers speed and brakes again, 3 m/s^2 at most, and its springs give way by 0.012 rad for each m/s^2.
TEST(Plausibility, ACarThatDipsAsItGathersSpeedIsNoGyroscopeThatReadsTooLittle) {
  const double w = 2.0 * std::numbers::pi / 12.0;
  const auto dips = [w](double t_s, auto& noise) -> Array3 {
    return {0.002 * noise(), -0.012 * 3.0 * w * std::cos(w * t_s) + 0.002 * noise(), 0.002 * noise()};
  };
  const auto acc = [w](double t_s) { return (1.0 + 0.012 * kStandardGravity_mps2) * 3.0 * std::sin(w * t_s); };
  EXPECT_TRUE(lying_level(6000, 10'000'000, dips, acc).empty());
}

/// A bicycle that starts falls upright at once, and lies still before and after it.
TEST(Plausibility, AKnockIsNoNoiseOfASensorInDegrees) {
  const auto knocked = [](double t_s, auto& noise) -> Array3 {
    const double since_s = std::fmod(t_s, 5.0);
    return {0.002 * noise(), 0.002 * noise(), (since_s < 0.02 ? 1.0 : since_s < 0.04 ? -1.0 : 0.0) + 0.002 * noise()};
  };
  EXPECT_TRUE(lying_level(3000, 10'000'000, knocked).empty());
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
