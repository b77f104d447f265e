/// Sensors that speak at their own times become samples led by the gyroscope, by their stamps alone.
#include <gtest/gtest.h>

#include <cmath>

#include "core/so3.h"
#include "core/units.h"
#include "pipeline/sources.h"
#include "pipeline/stages.h"

namespace stillpoint::pipeline {
namespace {

constexpr std::int64_t kMs = 1'000'000;

RawSample acc_at(std::int64_t t_ns, const Vec3& f = {0, 0, 9.80665}) {
  return {.t_ns = t_ns, .acc_mps2 = array(f), .has = kAcc};
}
RawSample gyr_at(std::int64_t t_ns, const Vec3& w = Vec3::Zero()) {
  return {.t_ns = t_ns, .gyr_radps = array(w), .has = kGyr};
}
RawSample mag_at(std::int64_t t_ns, const Vec3& m) { return {.t_ns = t_ns, .mag_uT = array(m), .has = kMag}; }

/// Guard and assembly as Stages joins them.
struct Front {
  GuardParams params;
  GuardStage guard{params};
  AssembleStage assemble{params.late_s, TriadCalibration{}};
  std::uint64_t sequence = 0;

  std::optional<GuardedSample> push(RawSample row) {
    row.sequence = sequence++;
    GuardedSample guarded, out;
    if (guard.process(row, guarded) == StageStatus::kDrop) return std::nullopt;
    if (assemble.process(guarded, out) == StageStatus::kDrop) return std::nullopt;
    return out;
  }
};

TEST(Assemble, AWholeRowPassesThroughUntouched) {
  Front front;
  const RawSample row{.t_ns = 5 * kMs,
                      .acc_mps2 = {1, 2, 9},
                      .gyr_radps = {0.1, 0.2, 0.3},
                      .mag_uT = {20, 0, -40},
                      .has = kAcc | kGyr | kMag};
  const auto out = front.push(row);
  ASSERT_TRUE(out.has_value());
  EXPECT_EQ(out->sample.acc_mps2, row.acc_mps2);
  EXPECT_EQ(out->sample.mag_uT, row.mag_uT);
  EXPECT_EQ(out->acc_turn_rad, Array3{});
  EXPECT_EQ(out->mag_turn_rad, Array3{});
}

TEST(Assemble, ReadingsOfTheirOwnJoinTheFirstGyroscopeReadingThatIsLateEnough) {
  Front front;
  front.params.late_s = 0.0;
  front = Front{.params = front.params};
  EXPECT_TRUE(front.push(gyr_at(0)).has_value());
  EXPECT_FALSE(front.push(acc_at(2 * kMs, {0, 0, 9})).has_value());
  EXPECT_FALSE(front.push(acc_at(4 * kMs, {0, 0, 11})).has_value());
  const auto out = front.push(gyr_at(5 * kMs, {0, 0, 2}));
  ASSERT_TRUE(out.has_value());
  EXPECT_TRUE(out->sample.holds(kAcc));
  EXPECT_DOUBLE_EQ(out->sample.acc_mps2[2], 10.0);
  EXPECT_NEAR(out->acc_turn_rad[2], 2 * 0.002, 1e-12) << "3 ms and 1 ms before, in the mean 2 ms at 2 rad/s";
  EXPECT_FALSE(front.push(gyr_at(10 * kMs)).value().sample.holds(kAcc)) << "nothing is used twice";
}

/// Readings of a field fixed in the world, each taken back to its own attitude, give that field exactly, however large
/// the body's own field is and however fast it turns.
TEST(Assemble, AReadingIsUsedInTheAttitudeOfItsOwnStamp) {
  const Vec3 rate(3.0, -5.0, 8.0), field(20, 5, -43), iron(600, -200, 100);
  const auto attitude = [&](std::int64_t t_ns) { return exp_quat(Vec3(rate * (in_seconds(t_ns)))); };
  Front front;
  double worst_uT = 0.0;
  int seen = 0;
  for (std::int64_t ms = 0; ms < 2000; ms += 1) {
    const std::int64_t t = ms * kMs;
    if (ms % 13 == 6) {
      EXPECT_FALSE(front.push(mag_at(t, attitude(t).conjugate() * field + iron)).has_value());
    }
    if (ms % 5 != 0) continue;
    const auto out = front.push(gyr_at(t, rate));
    ASSERT_TRUE(out.has_value());
    if (!out->sample.holds(kMag)) continue;
    const Quat at_reading = attitude(t) * exp_quat(Vec3(-vec(out->mag_turn_rad)));
    worst_uT = std::max(worst_uT, (at_reading * (vec(out->sample.mag_uT) - iron) - field).norm());
    ++seen;
  }
  EXPECT_GT(seen, 140);
  EXPECT_LT(worst_uT, 1e-9);
}

TEST(Assemble, TheOrderOfArrivalDoesNotMatterWithinTheBound) {
  // Accelerometer readings come up to 8 ms late, less than the bound of 10.
  std::vector<std::pair<std::int64_t, RawSample>> arrivals;
  for (std::int64_t k = 0; k < 400; ++k) {
    arrivals.push_back({5 * k * kMs, gyr_at(5 * k * kMs, {0.1 * static_cast<double>(k % 7), 0, 0.3})});
    const std::int64_t t = (7 * k + 1) * kMs;
    if (t < 2000 * kMs) arrivals.push_back({t + (k * 3 % 8) * kMs, acc_at(t, {0.01 * static_cast<double>(k), 0, 9.8})});
  }
  const auto run = [&](auto key) {
    auto rows = arrivals;
    std::stable_sort(rows.begin(), rows.end(), [&](const auto& a, const auto& b) { return key(a) < key(b); });
    Front front;
    std::vector<std::pair<std::int64_t, Array3>> out;
    for (const auto& [at, row] : rows)
      if (const auto s = front.push(row))
        out.push_back({s->sample.t_ns, s->sample.holds(kAcc) ? s->sample.acc_mps2 : Array3{}});
    EXPECT_EQ(front.guard.counts().late + front.guard.counts().refused, 0U);
    return out;
  };
  const auto live = run([](const auto& a) { return a.first; });
  const auto recorded = run([](const auto& a) { return a.second.t_ns; });
  EXPECT_EQ(live, recorded);
}

TEST(Assemble, AReadingBeyondTheBoundIsRefusedAndCounted) {
  Front front;
  for (int k = 0; k < 10; ++k) front.push(gyr_at(5 * k * kMs));
  front.push(acc_at(30 * kMs));
  EXPECT_EQ(front.guard.counts().late, 1U) << "15 ms behind the gyroscope, the bound is 10";
  front.push(acc_at(40 * kMs));
  EXPECT_EQ(front.guard.counts().late, 1U);
}

TEST(Assemble, ARateSlowerThanTheGyroscopesIsNoAbsenceASilentSensorIs) {
  Front front;
  int absent_while_speaking = 0;
  bool absent_after = false;
  for (std::int64_t ms = 0; ms < 3000; ++ms) {
    if (ms % 20 == 3 && ms < 2000) front.push(mag_at(ms * kMs, {20, 0, static_cast<double>(ms % 7)}));
    if (ms % 10 == 1) front.push(acc_at(ms * kMs, {0, 0, 9.8 + 1e-4 * static_cast<double>(ms % 11)}));
    if (ms % 5 != 0) continue;
    const auto out = front.push(gyr_at(ms * kMs));
    if (!out) continue;
    if (ms > 100 && ms < 2000) absent_while_speaking += (out->absent & (kAcc | kMag)) != 0 ? 1 : 0;
    if (ms > 2100) absent_after = (out->absent & kMag) != 0 && (out->absent & kAcc) == 0;
  }
  EXPECT_EQ(absent_while_speaking, 0);
  EXPECT_TRUE(absent_after);
}

TEST(Assemble, TheAccelerometerLeadsWhileTheGyroscopeIsSilent) {
  Front front;
  int before = 0, silent = 0, after = 0;
  for (std::int64_t ms = 0; ms < 3000; ++ms) {
    const bool gyroscope = ms < 1000 || ms >= 2000;
    if (ms % 5 == 2 && front.push(acc_at(ms * kMs))) ++(ms < 1000 ? before : ms < 2000 ? silent : after);
    if (ms % 5 == 0 && gyroscope) {
      EXPECT_TRUE(front.push(gyr_at(ms * kMs)).has_value()) << ms;
    }
  }
  EXPECT_EQ(before, 0);
  EXPECT_GT(silent, 180) << "an attitude must go on";
  EXPECT_LE(after, 1);
}

TEST(Assemble, RowsOfAReferenceAreNeitherSamplesNorGaps) {
  Front front;
  for (int k = 0; k < 100; ++k) {
    RawSample row = gyr_at(10 * k * kMs);
    EXPECT_TRUE(front.push(row).has_value());
    EXPECT_FALSE(front.push({.t_ns = (10 * k + 4) * kMs}).has_value());
  }
  const GuardCounts& c = front.guard.counts();
  EXPECT_EQ(c.samples, 100U);
  EXPECT_EQ(c.refused + c.gaps + c.lost + c.late, 0U);
}

/// A body that turns and is shaken, seen once in whole rows at 200 Hz and once by sensors of other rates and phases:
/// the attitude is the same.
TEST(Assemble, StreamsGiveTheAttitudeOfWholeRows) {
  const auto rate = [](double t) {
    return Vec3(1.5 * std::sin(2.1 * t), 1.1 * std::sin(1.3 * t + 1), 0.9 * std::cos(t));
  };
  std::vector<Quat> truth;  // every 100 us
  Quat q = Quat::Identity();
  for (int k = 0; k <= 400'000; ++k) {
    truth.push_back(q);
    q = renormalized(q * exp_quat(Vec3(1e-4 * rate(1e-4 * (k + 0.5)))));
  }
  const auto force = [&](std::int64_t t_us) {
    const double t = 1e-6 * static_cast<double>(t_us);
    return Vec3(truth[static_cast<std::size_t>(t_us / 100)].conjugate() *
                Vec3(0.8 * std::sin(9 * t), 0.5 * std::cos(7 * t), 9.80665 + 0.4 * std::sin(8 * t)));
  };
  const auto field = [&](std::int64_t t_us) {
    return Vec3(truth[static_cast<std::size_t>(t_us / 100)].conjugate() * Vec3(0, 20, -43));
  };
  const auto error_deg = [&](bool streams) {
    calib::OnlineCalibrator calibrator({}, {});
    DirectLink link(calibrator);
    Stages stages(StagesParams{}, calibrator.snapshot());
    Processed out;
    double worst = 0.0;
    std::uint64_t sequence = 0;
    const auto push = [&](RawSample s) {
      s.sequence = sequence++;
      if (stages.process(s, out, link) == StageStatus::kDrop || s.t_ns < 20'000'000'000) return;
      const Quat at = truth[static_cast<std::size_t>(out.attitude.t_ns / 100'000)];
      worst = std::max(worst, 2 * std::acos(std::min(1.0, std::abs(at.dot(quat(out.attitude.q_world_body))))));
    };
    for (std::int64_t us = 0; us < 40'000'000; us += 100) {
      const std::int64_t t_ns = 1000 * us;
      const double w_s = 1e-6 * static_cast<double>(us) - (streams ? 0.0033 : 0.0025);  // mean over its step
      if (!streams && us % 5000 == 0)
        push({.t_ns = t_ns,
              .acc_mps2 = array(force(us)),
              .gyr_radps = array(rate(w_s)),
              .mag_uT = array(field(us)),
              .has = kAcc | kGyr | kMag});
      if (streams && us % 5000 == 1300) push(acc_at(t_ns, force(us)));
      if (streams && us % 20'000 == 7100) push(mag_at(t_ns, field(us)));
      if (streams && us % 6600 == 0) push(gyr_at(t_ns, rate(w_s)));
    }
    return worst * kDegPerRad;
  };
  const double rows = error_deg(false), streams = error_deg(true);
  EXPECT_LT(rows, 1.5);
  EXPECT_LT(streams, rows + 0.3);
}

}  // namespace
}  // namespace stillpoint::pipeline
