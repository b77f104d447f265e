/// Turns of known angle: what they teach of the gyroscope's matrix, with a deviation that holds, and which are refused.
#include "calib_online/known_turn.h"

#include <gmock/gmock.h>

#include "calib_online/online_calibrator.h"
#include "core/so3.h"
#include "core/units.h"
#include "tests/calib_online/synthetic.h"

namespace stillpoint::calib {
namespace {

using ::testing::HasSubstr;

constexpr double kHand_rad = 1.5 * kRadPerDeg;
constexpr double kTurntable_radps = 200.0 * kRadPerDeg;  // 33 1/3 rpm

/// A recording in the making, and the turns that are known of it.
class Bench {
 public:
  Bench(const Mat3& H, unsigned seed) : truth_(truth(H)), source_(truth_, seed) {}

  void rest(double seconds) { run(seconds, {}); }
  /// `angle_rad` in four seconds about this axis of the body, which leans by `wobble_rad` to either side at 0.7 Hz.
  void turn(const Vec3& axis, double angle_rad, double wobble_rad = 0.0) {
    constexpr double kSeconds = 4.0, kWobble_radps = 2.0 * std::numbers::pi * 0.7;
    const Vec3 lean = axis.unitOrthogonal(), side = axis.cross(lean);
    const auto leans = [=](double t) {
      return wobble_rad * std::sin(kWobble_radps * t) * std::pow(std::sin(std::numbers::pi * t / kSeconds), 2);
    };
    run(kSeconds, [=](double t) {
      const double rate = angle_rad / kSeconds * (1.0 - std::cos(2.0 * std::numbers::pi * t / kSeconds));
      const double e = leans(t), e_rate = (leans(t + 1e-4) - leans(t - 1e-4)) / 2e-4;
      return Vec3(rate * (std::cos(e) * axis + std::sin(e) * side) + e_rate * lean);
    });
  }
  void steady(const Vec3& rate_radps, double seconds) {
    run(seconds, [=](double) { return rate_radps; });
  }
  /// Once around by hand between two rests: comes back by a random 1.5 deg, and a jitter of 1 deg where it stops.
  StatedTurn hand_turn(const Vec3& axis, double wobble_rad = 0.0) {
    rest(2.0);
    const double begin_s = now_s() - 1.0;
    turn(axis, 2.0 * std::numbers::pi + source_.noise(kHand_rad).x(), wobble_rad);
    constexpr double kJitter_radps = 1.0 * kRadPerDeg * 2.0 * std::numbers::pi / 0.2;
    run(0.2, [=](double t) { return Vec3(kJitter_radps * std::sin(2.0 * std::numbers::pi * t / 0.2) * axis); });
    rest(2.0);
    return {begin_s, now_s() - 1.0, 2.0 * std::numbers::pi, kHand_rad};
  }

  [[nodiscard]] double now_s() const { return t_ns.empty() ? 0.0 : in_seconds(t_ns.back() - t_ns[0]); }
  [[nodiscard]] Result<KnownTurn> known(const StatedTurn& stated) const {
    constexpr double kBiasSd_radps = 1e-4;
    return known_turn(stated, t_ns, gyr_radps, truth_.b_gyr, Mat3(kBiasSd_radps * kBiasSd_radps * Mat3::Identity()));
  }
  std::vector<std::int64_t> t_ns;
  std::vector<Vec3> gyr_radps;

 private:
  static test::SensorTruth truth(const Mat3& H) {
    test::SensorTruth t;
    t.H_gyr = H;
    t.b_gyr = Vec3(0.02, -0.03, 0.01);
    return t;
  }
  void run(double seconds, std::function<Vec3(double)> rate) {
    test::Motion motion;
    if (rate) motion.rate_radps = std::move(rate);
    source_.run(seconds, motion, [this](const RawSample& s) {
      t_ns.push_back(s.t_ns);
      gyr_radps.emplace_back(vec(s.gyr_radps));
    });
  }
  test::SensorTruth truth_;
  test::Synthetic source_;
};

/// Scales that are 1, 10 and 30 % off, in an order and with signs by the seed, and axes off by 15 mrad (sd).
Mat3 bad_matrix(unsigned seed) {
  std::mt19937_64 random(900 + seed);
  std::normal_distribution<double> normal;
  Mat3 H = Mat3::Identity();
  const std::array<double, 3> off{0.01, 0.10, 0.30};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      H(i, j) += i == j ? (random() % 2 == 0 ? 1.0 : -1.0) * off[(seed + static_cast<unsigned>(i)) % 3]
                        : 0.015 * normal(random);
  return H;
}

double sd_of(const OnlineCalibrator& c, int row, int column) {
  return std::sqrt(c.gyr_matrix().covariance(3 * row + column, 3 * row + column));
}

TEST(KnownTurn, ItsRowIsTheCentralDifferenceOfTheAngle) {
  GyroMatrixFit fit;
  fit.H = bad_matrix(1);
  KnownTurn turn{.integral_rad = Vec3(3.0, -4.0, 2.0), .angle_rad = 5.0, .variance_rad2 = 0.04};
  GyroMatrixSums sums;
  add_known_turn(fit, turn, sums);
  Vec9 slope;
  constexpr double kStep = 1e-6;
  for (int k = 0; k < 9; ++k) {
    const auto angle = [&](double step) {
      GyroMatrixFit moved = fit;
      moved.H(k / 3, k % 3) += step;
      return seen_by(moved, turn).angle_rad;
    };
    slope[k] = (angle(kStep) - angle(-kStep)) / (2.0 * kStep);
  }
  std::size_t k = 0;
  for (int i = 0; i < 9; ++i) {
    for (int j = 0; j <= i; ++j, ++k) EXPECT_NEAR(sums.lower[k], slope[i] * slope[j] / 0.04, 1e-5) << i << j;
    EXPECT_NEAR(sums.rhs[static_cast<std::size_t>(i)], slope[i] * 5.0 / 0.04, 1e-5) << i;
  }
}

TEST(KnownTurn, ItsDeviationIsThatOfTurnsDrawnFromWhatIsNotKnown) {
  GyroMatrixFit fit;
  fit.H = bad_matrix(2);
  std::mt19937_64 random(31);
  std::normal_distribution<double> normal;
  const Vec3 Z(0.3, 6.2, -0.4);
  const double bias_rad = 0.05;
  const KnownTurn turn{.integral_rad = Z, .integral_of_bias = bias_rad * bias_rad * Mat3::Identity(), .angle_rad = 6.0};
  // Scales well known, axes hardly: most is by the square of what lies across.
  for (const auto& [scale_sd, cross_sd] : {std::pair(0.03, 0.01), std::pair(0.002, 0.1), std::pair(0.0, 0.0)}) {
    Vec9 sd = Vec9::Constant(cross_sd);
    for (int k = 0; k < 9; k += 4) sd[k] = scale_sd;
    fit.covariance = sd.cwiseAbs2().asDiagonal();
    const AngleSeen seen = seen_by(fit, turn);
    double squares = 0.0;
    constexpr int kDraws = 4000;
    for (int draw = 0; draw < kDraws; ++draw) {
      Mat3 H = fit.H;
      for (int k = 0; k < 9; ++k) H(k / 3, k % 3) += sd[k] * normal(random);
      const Vec3 bias = bias_rad * Vec3(normal(random), normal(random), normal(random));
      squares += std::pow((H * (Z + bias)).norm() - seen.angle_rad, 2);
    }
    // 4000 draws: 1.1 % by chance, times three.
    EXPECT_NEAR(std::sqrt(squares / kDraws) / std::sqrt(seen.own_var + seen.matrix_var), 1.0, 0.04) << cross_sd;
  }
}

TEST(KnownTurn, TheMatrixMeetsTurnsAboutSlantingAxes) {
  Bench bench(Vec3(1.3, 0.7, 1.0).asDiagonal(), 11);
  std::vector<KnownTurn> turns;
  for (const Vec3& axis : {Vec3(1.0, 0.5, 0.3), Vec3(-0.4, 1.0, 0.5), Vec3(0.3, -0.5, 1.0)})
    turns.push_back(*bench.known(bench.hand_turn(axis.normalized())));
  OnlineCalibrator calibrator({}, {});
  ASSERT_TRUE(calibrator.absorb(turns));
  // Three turns and three scales: the prior draws by a hundredth of a deviation.
  for (const KnownTurn& turn : turns)
    EXPECT_LT(std::abs(seen_by(calibrator.gyr_matrix(), turn).residual_sd(turn.angle_rad)), 0.1);
}

TEST(KnownTurn, OneAboutEachAxisTeachesScalesThatAre30PercentOff) {
  constexpr unsigned kSeeds = 40;
  int inside = 0, scales_inside = 0;
  for (unsigned seed = 0; seed < kSeeds; ++seed) {
    const Mat3 H = bad_matrix(seed);
    Bench bench(H, seed);
    std::vector<KnownTurn> turns;
    for (int axis = 0; axis < 3; ++axis) {
      // Laid down by hand: the axis is not quite the body's; it wobbles by 2 deg.
      const StatedTurn stated =
          bench.hand_turn((Vec3::Unit(axis) + 0.03 * Vec3::Unit((axis + 1) % 3)).normalized(), 0.035);
      const auto known = bench.known(stated);
      ASSERT_TRUE(known) << known.error().message;
      turns.push_back(*known);
    }
    OnlineCalibrator calibrator({}, {});
    ASSERT_TRUE(calibrator.absorb(turns));
    const Mat3 error = mat(calibrator.snapshot().gyr.matrix) - H;
    for (int i = 0; i < 3; ++i) {
      EXPECT_TRUE(turns[static_cast<std::size_t>(i)].used) << seed;
      EXPECT_LT(sd_of(calibrator, i, i), 0.008) << seed;  // 1.5 deg of 360, times the scale of 1.3, and 0.2 %
      for (int j = 0; j < 3; ++j) inside += std::abs(error(i, j)) < 3.0 * sd_of(calibrator, i, j);
      scales_inside += std::abs(error(i, i)) < sd_of(calibrator, i, i);
    }
  }
  std::printf("inside 3 deviations: %d of %u elements; inside one: %d of %u scales\n", inside, 9 * kSeeds,
              scales_inside, 3 * kSeeds);
  EXPECT_GE(inside, 0.98 * 9 * kSeeds);
  // Nor are they far wider than they have to be: 68 % of the scales inside one, by chance 6 % more or less.
  EXPECT_GT(scales_inside, 0.55 * 3 * kSeeds);
  EXPECT_LT(scales_inside, 0.88 * 3 * kSeeds);
}

TEST(KnownTurn, ATurntableTeachesItsOwnAxisOnly) {
  const Mat3 H = Vec3(1.01, 0.98, 1.025).asDiagonal();
  Bench bench(H, 7);
  bench.rest(2.0);
  bench.steady(kTurntable_radps * Vec3::UnitZ(), 60.0);
  auto known = bench.known({2.5, 61.5, kTurntable_radps * 59.0, 0.003 * kTurntable_radps * 59.0, true});
  ASSERT_TRUE(known) << known.error().message;
  OnlineCalibrator calibrator({}, {});
  const GyroMatrixFit before = calibrator.gyr_matrix();
  ASSERT_TRUE(calibrator.absorb({&*known, 1}));
  const GyroMatrixFit& after = calibrator.gyr_matrix();
  EXPECT_LT(std::sqrt(after.covariance(8, 8)), 0.005);
  EXPECT_NEAR(after.H(2, 2), H(2, 2), 3.0 * std::sqrt(after.covariance(8, 8)));
  for (int k = 0; k < 8; ++k) EXPECT_GT(after.covariance(k, k), 0.98 * before.covariance(k, k)) << k;
}

TEST(KnownTurn, AScaleBeyondTheFactorysLeavesTheOtherAxesInDoubt) {
  Bench bench(Vec3(1.3, 1.0, 1.0).asDiagonal(), 3);
  auto known = bench.known(bench.hand_turn(Vec3::UnitX()));
  ASSERT_TRUE(known) << known.error().message;
  OnlineCalibrator calibrator({}, {}), resumed({}, {});
  const double prior_sd = sd_of(calibrator, 1, 1);
  ASSERT_TRUE(calibrator.absorb({&*known, 1}));
  for (const int axis : {1, 2}) EXPECT_GT(sd_of(calibrator, axis, axis), 2.0 * prior_sd);
  // What a daemon takes over.
  ASSERT_TRUE(resumed.restore(calibrator.state()));
  EXPECT_EQ(resumed.snapshot().gyr.matrix, calibrator.snapshot().gyr.matrix);
  EXPECT_EQ(resumed.gyr_matrix().covariance, calibrator.gyr_matrix().covariance);
}

TEST(KnownTurn, WhatContradictsTurnsThatAreKnownIsNotUsed) {
  Bench bench(Mat3::Identity(), 5);
  std::vector<KnownTurn> good;
  for (int k = 0; k < 3; ++k) good.push_back(*bench.known(bench.hand_turn(Vec3::UnitX())));
  KnownTurn wrong = *bench.known(bench.hand_turn(Vec3::UnitX()));
  wrong.angle_rad *= 1.1;  // somebody's 396 deg
  OnlineCalibrator without({}, {});
  ASSERT_TRUE(without.absorb(good));
  for (std::size_t place = 0; place <= good.size(); ++place) {
    std::vector<KnownTurn> turns = good;
    turns.insert(turns.begin() + static_cast<std::ptrdiff_t>(place), wrong);
    OnlineCalibrator calibrator({}, {});
    ASSERT_TRUE(calibrator.absorb(turns));
    for (std::size_t k = 0; k < turns.size(); ++k) EXPECT_EQ(turns[k].used, k != place) << place;
    EXPECT_EQ(calibrator.snapshot().gyr.matrix, without.snapshot().gyr.matrix) << place;
  }
}

TEST(KnownTurn, WhichWayItTurnsDoesNotMatterAndManyTurnsSayMore) {
  const Mat3 H = Vec3(1.0, 1.0, 0.98).asDiagonal();
  Bench bench(H, 6);
  bench.rest(2.0);
  for (int k = 0; k < 10; ++k) bench.turn(-Vec3::UnitZ(), 2.0 * std::numbers::pi);
  bench.rest(2.0);
  auto known = bench.known({1.0, 43.0, 20.0 * std::numbers::pi, kHand_rad});
  ASSERT_TRUE(known) << known.error().message;
  OnlineCalibrator calibrator({}, {});
  ASSERT_TRUE(calibrator.absorb({&*known, 1}));
  EXPECT_LT(sd_of(calibrator, 2, 2), 0.003);  // 0.2 % of what no matrix describes
  EXPECT_NEAR(mat(calibrator.snapshot().gyr.matrix)(2, 2), 0.98, 3.0 * sd_of(calibrator, 2, 2));
}

TEST(KnownTurn, AnAxisThatWandersIsBorneWhileItMattersLittleAndRefusedBeyond) {
  Bench bench(Mat3::Identity(), 8);
  const StatedTurn little = bench.hand_turn(Vec3::UnitZ(), 0.06), much = bench.hand_turn(Vec3::UnitZ(), 0.3);
  const auto calm = bench.known(bench.hand_turn(Vec3::UnitZ())), bearable = bench.known(little);
  ASSERT_TRUE(calm && bearable) << bearable.error().message;
  // sin(e) across the axis, rms 0.06 / sqrt(2) times sqrt(3 / 8) and a bit where the turn is fast: half its square.
  EXPECT_GT(bearable->variance_rad2 - calm->variance_rad2, std::pow(0.5 * 0.001 * 2.0 * std::numbers::pi, 2));
  const auto refused = bench.known(much);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("the axis moves in the body"));
}

class KnownTurnRefused : public ::testing::Test {
 protected:
  KnownTurnRefused() {
    stated_ = bench_.hand_turn(Vec3::UnitY());
    bench_.rest(2.0);
  }
  std::string why(const StatedTurn& stated) {
    const auto known = bench_.known(stated);
    return known ? "" : known.error().message;
  }
  Bench bench_{Mat3::Identity(), 9};
  StatedTurn stated_;
};

TEST_F(KnownTurnRefused, OutsideOfTheRecordingNotAtRestNoTurnNotSteady) {
  EXPECT_EQ(why(stated_), "");
  EXPECT_THAT(why({2.0, 1000.0, 6.28, 0.03}), HasSubstr("the recording lasts 10.190 s"));
  EXPECT_THAT(why({3.0, stated_.end_s, 6.28, 0.03}), HasSubstr("at 3 s it turns by"));
  EXPECT_THAT(why({stated_.begin_s, 5.0, 6.28, 0.03}), HasSubstr("at 5 s it turns by"));
  EXPECT_THAT(why({8.0, 10.0, 6.28, 0.03}), HasSubstr("it turns by 0.0 deg only"));
  EXPECT_THAT(why({stated_.begin_s, stated_.end_s, 6.28, 0.03, true}), HasSubstr("the rate is not steady"));
  EXPECT_THAT(why({3.0, 3.05, 6.28, 0.03}), HasSubstr("the gyroscope was read 6 times"));
}

TEST_F(KnownTurnRefused, AGapInTheReadings) {
  for (std::size_t k = 400; k < 404; ++k) bench_.gyr_radps[k] = Vec3::Constant(std::nan(""));
  EXPECT_THAT(why(stated_), HasSubstr("no reading of the gyroscope from 3.990 to 4.040 s"));
}

TEST_F(KnownTurnRefused, AClippedAxis) {
  const double lattice = 0.001, rail = 2.5;
  for (Vec3& y : bench_.gyr_radps)
    y = (y / lattice).array().round().matrix().cwiseMin(rail / lattice).cwiseMax(-rail / lattice) * lattice;
  EXPECT_THAT(why(stated_), HasSubstr("the gyroscope is clipped from 3."));
}

TEST_F(KnownTurnRefused, ALatticeIsNoClipping) {
  const double lattice = 0.02;
  for (Vec3& y : bench_.gyr_radps) y = (y / lattice).array().round().matrix() * lattice;
  EXPECT_EQ(why(stated_), "");
}

}  // namespace
}  // namespace stillpoint::calib
