/// What becomes of samples that are no measurements, and of a reference that was lost for a while.
#include "diagnosis/reference/signals.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <random>

#include "core/so3.h"
#include "diagnosis/reference/band_limit.h"
#include "diagnosis/sanity/rows_with_reference.h"
#include "io/simulated_recording.h"
#include "simulation/simulator.h"
#include "tests/diagnosis/simulated.h"

namespace stillpoint::diag {
namespace {

sim::SimulationConfig plain_baseline() {
  sim::SimulationConfig s;
  s.rate_hz = 200;
  s.accelerometer = sim::TriadConfig{.noise_sd = 0.02};
  s.gyroscope = sim::TriadConfig{.noise_sd = 0.001};
  s.magnetometer = sim::TriadConfig{.noise_sd = 0.3};
  s.motion = sim::MotionConfig{};
  s.motion->duration_s = 30;
  s.reference.kind = "mocap";
  return s;
}

io::Recording record() { return io::to_recording(sim::simulate(plain_baseline(), 5)); }

TEST(Thinned, TakesItsMeansFromMeasurementsOnly) {
  auto r = record();
  std::array<Mask, kSensors> muted;
  muted[kMag].assign(r.size(), 1);
  for (std::size_t i = 0; i < r.size(); i += 4) muted[kMag][i] = 0;  // held: three rows of four carry nothing new
  for (std::size_t i = 0; i < r.size(); ++i)
    if (muted[kMag][i]) r.mag_uT[i] = Vec3::Constant(1e6);
  const auto s = make_signals(r, plain_baseline(), muted);
  ASSERT_TRUE(s);
  const Signals t = thinned(*s, 4);
  ASSERT_EQ(t.n, s->n / 4);
  const auto middle = t.n / 2;
  EXPECT_EQ(t.muted[kMag][static_cast<std::size_t>(middle)], 0);
  EXPECT_EQ(t.reading[kMag].row(middle), s->reading[kMag].row(4 * middle));
  EXPECT_LT(t.residual[kMag].row(middle).norm(), 5.0);
}

TEST(Thinned, WorksWithoutAMagnetometer) {
  auto r = record();
  r.mag_uT.clear();
  const auto s = make_signals(r, plain_baseline(), {});
  ASSERT_TRUE(s);
  EXPECT_EQ(thinned(*s, 4).predicted[kMag].rows(), s->predicted[kMag].rows() / 4);
}

TEST(Signals, MutesWhereTheReferenceWasLost) {
  auto r = record();
  for (std::size_t i = 3000; i < 3100; ++i) r.ref_q_world_body[i].setConstant(io::kMissing);
  const auto s = make_signals(r, plain_baseline(), {});
  ASSERT_TRUE(s);
  ASSERT_FALSE(s->exact_reference);
  const auto second = static_cast<std::size_t>(std::lround(1.0 / s->dt_s));
  for (const int k : {kAcc, kGyr, kMag}) {
    EXPECT_EQ(s->muted[k][3000 - second], 0) << k;
    EXPECT_EQ(s->muted[k][2997], 1) << "differences reach into the gap";
    EXPECT_EQ(s->muted[k][2990], k == kMag) << "and so does the filter through which the field is seen";
    EXPECT_EQ(s->muted[k][3050], 1) << k;
    EXPECT_EQ(s->muted[k][3100 + second], 0) << k;
  }
}

TEST(Signals, HoldsTheDriverStillAtRest) {
  const auto s = make_signals(record(), plain_baseline(), {});
  ASSERT_TRUE(s);
  ASSERT_FALSE(s->exact_reference);
  int rests = 0;
  for (Eigen::Index i = 1; i < s->n; ++i) {
    if (!s->rest[static_cast<std::size_t>(i)] || !s->rest[static_cast<std::size_t>(i - 1)]) continue;
    ++rests;
    ASSERT_EQ(s->vector[kAcc].row(i), s->vector[kAcc].row(i - 1)) << i;
    ASSERT_EQ(s->vector[kGyr].row(i).norm(), 0.0) << i;
  }
  EXPECT_GT(rests, 200);
}

/// A bridge carries two noisy values through the whole gap; the rows that were measured say more of the rest.
TEST(Signals, TakeTheAttitudeOfARestFromWhatWasMeasured) {
  sim::SimulationConfig config = plain_baseline();
  config.motion->kind = "rest_poses";
  config.motion->max_rest_s = 8.0;
  io::Recording r = io::to_recording(sim::simulate(config, 5));
  const auto whole = make_signals(r, config, {});
  ASSERT_TRUE(whole);
  std::size_t begin = 400, end = begin;
  for (std::size_t b = 0, e = 0; b < r.size(); b = e + 1) {
    for (e = b; e < r.size() && whole->rest[e]; ++e) continue;
    if (e - b > end - begin) begin = b, end = e;
  }
  ASSERT_GT(end - begin, 600U);
  const std::size_t first = begin + 100, last = end - 100;
  for (std::size_t i = first; i <= last; ++i) r.ref_q_world_body[i].setConstant(io::kMissing);
  for (const std::size_t beside : {first - 1, last + 1})
    r.ref_q_world_body[beside] += 0.01 * Eigen::Vector4d(-r.ref_q_world_body[beside][1], r.ref_q_world_body[beside][0],
                                                         r.ref_q_world_body[beside][3], -r.ref_q_world_body[beside][2]);
  const auto lost = make_signals(r, config, {});
  ASSERT_TRUE(lost);
  const auto middle = static_cast<Eigen::Index>((begin + end) / 2);
  for (std::size_t axis = 0; axis < 3; ++axis)
    EXPECT_LT((lost->world_axis[axis].row(middle) - whole->world_axis[axis].row(middle)).norm(), 2.5e-3) << axis;
}

TEST(Signals, FindNoRestWhereAQuietBoatSwings) {
  auto config = plain_baseline();
  config.motion->kind = "boat";
  for (const std::string reference : {"exact", "mocap"}) {
    config.reference.kind = reference;
    const auto s = make_signals(io::to_recording(sim::simulate(config, 5)), config, {});
    ASSERT_TRUE(s);
    EXPECT_EQ(std::accumulate(s->rest.begin(), s->rest.end(), 0), 0) << reference;
    EXPECT_EQ(s->exact_reference, reference == "exact") << "known without a rest";
  }
}

TEST(Signals, KnowANoisyReferenceByItsFramesAndNotByWhatWasInterpolatedBetweenThem) {
  auto config = plain_baseline();
  config.motion->kind = "boat";
  config.reference = {.kind = "mocap", .orientation_sd_rad = 5e-4, .position_sd_m = 1e-4, .band_hz = 3.0};
  io::Recording r = io::to_recording(sim::simulate(config, 5));
  for (std::size_t i = 0; i < r.size(); ++i)
    if (i % 2 != 0) r.ref_q_world_body[i].setConstant(io::kMissing), r.ref_position_m[i].setConstant(io::kMissing);
  std::vector<std::string> notices;
  const RowsWithReference rows = rows_with_reference(r, notices);
  ASSERT_EQ(rows.rows_a_frame, 2U);
  EXPECT_FALSE(make_signals(*rows.changed, config, {}, nullptr, 2)->exact_reference);
}

TEST(Signals, HoldTheVerticalAndThePlaceOfATurntableStillBesideACamera) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  const auto noise = [&](double sd) { return Vec3(sd * normal(random), sd * normal(random), sd * normal(random)); };
  io::Recording r;
  for (int i = 0; i < 6000; ++i) {
    const double t_s = 0.005 * i, turned_rad = std::cos(0.4 * t_s);
    const Quat seen = exp_quat(Vec3(0, 0, turned_rad)) * exp_quat(noise(5e-4));
    r.t_ns.push_back(5'000'000LL * i);
    r.ref_q_world_body.emplace_back(seen.w(), seen.x(), seen.y(), seen.z());
    r.ref_position_m.push_back(noise(1e-4));
    r.acc_mps2.push_back(Vec3(0, 0, 9.80665) + noise(0.02));
    r.gyr_radps.push_back(Vec3(0, 0, -0.4 * std::sin(0.4 * t_s)) + noise(1e-3));
    r.mag_uT.push_back(Vec3(20, 0, -40) + noise(0.3));
  }
  const auto s = make_signals(r, plain_baseline(), {});
  ASSERT_TRUE(s && !s->exact_reference);
  const auto wobble = [](const Series3& x) { return (x.rowwise() - x.colwise().mean()).cwiseAbs().maxCoeff(); };
  EXPECT_LT(wobble(s->world_axis[2]), 1e-12);
  EXPECT_LT(wobble(s->position_m), 1e-12);
  EXPECT_GT(wobble(s->world_axis[0]), 0.5) << "it turns";
}

TEST(MotionBand, EndsWhereNoiseIsAlsoWithoutARest) {
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0.0, 0.02);
  const double dt_s = 0.01;
  Series3 x(6000, 3);
  for (Eigen::Index i = 0; i < x.rows(); ++i)
    for (int axis = 0; axis < 3; ++axis)
      x(i, axis) = std::sin(2.0 * M_PI * 1.3 * dt_s * static_cast<double>(i) + axis) + noise(random);
  const Mask none(static_cast<std::size_t>(x.rows()), 0);
  const double band_Hz = motion_band_hz(x, none, dt_s, 60.0, 1.5, 20.0);
  EXPECT_GE(band_Hz, 1.2);
  EXPECT_LT(band_Hz, 4.0) << "above there is only what the residual has, too";
}

TEST(Signals, TakeAReferenceOfFewDecimalsForANoisyOne) {
  auto config = plain_baseline();
  config.reference.kind = "exact";
  const auto with_decimals = [&config](double rate_hz, double step_m) {
    config.rate_hz = rate_hz;
    io::Recording r = io::to_recording(sim::simulate(config, 5));
    for (Vec3& p : r.ref_position_m) p = ((p / step_m).array().round() * step_m).matrix();
    return *make_signals(r, config, {});
  };
  EXPECT_TRUE(with_decimals(50, 1e-7).exact_reference) << "0.0002 m/s^2 beside a noise of 0.02";
  const Signals s = with_decimals(200, 1e-6);
  EXPECT_FALSE(s.exact_reference) << "0.04 m/s^2, in motion only";
  EXPECT_TRUE(s.notices.empty()) << "rounding is not a vibration: " << s.notices.front();
}

/// The body turns by a few milliradians while it rests, and the gyroscope says so.
TEST(Signals, TakeASwayThatTheGyroscopeSeesForNoNoiseOfTheReference) {
  auto config = plain_baseline();
  config.reference.kind = "exact";
  config.gyroscope->noise_sd = 3e-4;
  io::Recording r = io::to_recording(sim::simulate(config, 5));
  const double rate_radps = 2e-3, w_radps = 3.0;
  test::turn_reference(r, [&](double t_s) { return Vec3(rate_radps / w_radps * std::sin(w_radps * t_s), 0, 0); });
  EXPECT_FALSE(make_signals(r, config, {})->exact_reference) << "the reference sways alone";
  for (std::size_t i = 0; i < r.size(); ++i)
    r.gyr_radps[i].x() += rate_radps * std::cos(w_radps * (r.t_s(i) - r.t_s(0)));
  EXPECT_TRUE(make_signals(r, config, {})->exact_reference);
}

TEST(Differences, CarryAVibrationOfAFifthOfTheRateAndSayWhereTheyFail) {
  const double dt_s = 0.005;
  const RowTimes rows{dt_s, {}};
  for (const double f_hz : {20.0, 40.0, 80.0}) {
    const double w = 2.0 * M_PI * f_hz;
    Series3 x(400, 3), first(400, 3), second(400, 3);
    for (Eigen::Index i = 0; i < x.rows(); ++i)
      for (int a = 0; a < 3; ++a) {
        const double phase = w * static_cast<double>(i) * dt_s + a;
        x(i, a) = std::sin(phase), first(i, a) = w * std::cos(phase), second(i, a) = -w * w * std::sin(phase);
      }
    const auto off = [](const Series3& d, const Series3& truth) {
      return (d - truth).middleRows(20, 360).cwiseAbs().maxCoeff() / truth.cwiseAbs().maxCoeff();
    };
    EXPECT_EQ(off(derivative(x, rows), first) < 1e-4, f_hz < 50) << f_hz;
    EXPECT_EQ(off(second_derivative(x, rows), second) < 1e-4, f_hz < 50) << f_hz;
    EXPECT_EQ(second_derivative_error(x, rows)[200] < 1e-3 * w * w, f_hz < 50) << f_hz;
    EXPECT_GT(10.0 * derivative_error(x, rows)[200], (derivative(x, rows) - first).row(200).norm()) << f_hz;
  }
}

}  // namespace
}  // namespace stillpoint::diag
