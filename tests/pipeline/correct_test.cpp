/// Which calibration the attitude is given.
#include <gtest/gtest.h>

#include <fstream>

#include "core/so3.h"
#include "core/units.h"
#include "pipeline/stages.h"
#include "simulation/random.h"
#include "tests/pipeline/simulated_run.h"
#include "tests/source_folder.h"

namespace stillpoint::pipeline {
namespace {

GuardedSample level() {
  GuardedSample in;
  in.sample.acc_mps2 = {0.0, 0.0, 9.8};
  in.sample.has = kAcc;
  return in;
}

/// What is corrected of a level reading, after snapshots of these states with an offset of 0.7, 0.6, ... m/s^2.
double sideways(std::initializer_list<CalibrationStatus> states) {
  CorrectStage stage({});
  CalibrationSnapshot snapshot;
  snapshot.acc.bias[0] = 0.8;
  for (const CalibrationStatus state : states) {
    snapshot.acc.bias[0] -= 0.1;
    snapshot.acc.status = state;
    stage.use(snapshot);
  }
  CalibratedSample out;
  (void)stage.process(level(), out);
  return -out.acc_mps2[0];
}

TEST(Correct, AnAccelerometersOffsetsAreTakenOnceTheyAreKnown) {
  using enum CalibrationStatus;
  EXPECT_EQ(sideways({kTooFewWindows, kNotObservable}), 0.0);
  EXPECT_NEAR(sideways({kTooFewWindows, kOk}), 0.6, 1e-12);
  EXPECT_NEAR(sideways({kOk, kNotObservable}), 0.7, 1e-12);  // the last that was known
  EXPECT_NEAR(sideways({kOk, kReplaced}), 0.6, 1e-12);
}

/// A car that brakes by 2 m/s^2 and stands, mounted any way: the push makes gravity 2 % longer, in one attitude of two.
TEST(Correct, OneWindowThatWasPushedDoesNotLeanTheRest) {
  double worst_rad = 0.0;
  for (unsigned seed = 1; seed <= 8; ++seed) {
    sim::Stream random(seed, "braking");
    const Quat mount = exp_quat(random.normal3());
    calib::OnlineCalibrator calibrator({}, {});
    DirectLink link(calibrator);
    Stages stages({}, calibrator.snapshot());
    Processed out;
    for (int i = 0; i < 1500; ++i) {
      const double brake_mps2 = i < 400 ? 2.0 + std::sin(0.05 * i) : i < 650 ? 2.0 : 0.0;
      const Vec3 force(-brake_mps2, 0.0, kStandardGravity_mps2);
      RawSample s;
      s.t_ns = 10'000'000LL * i;
      s.sequence = static_cast<std::uint64_t>(i);
      s.has = kAcc | kGyr;
      s.acc_mps2 = array(Vec3(mount.conjugate() * force + 0.02 * random.normal3()));
      s.gyr_radps = array(Vec3(0.002 * random.normal3()));
      (void)stages.process(s, out, link);
    }
    const Vec3 up = quat(out.attitude.q_world_body) * (mount.conjugate() * Vec3::UnitZ());
    worst_rad = std::max(worst_rad, std::atan2(up.head<2>().norm(), up.z()));
  }
  EXPECT_LT(worst_rad, 0.02);  // 0.10 where what few attitudes say is taken
}

/// A sensor three times worse than data sheets allow, once it has been learnt: what the filter had made of its errors
/// by itself is not counted twice, and how it sits in its housing stays unknown.
TEST(Correct, ASensorOutOfTheBoxIsStatedOnceItIsLearnt) {
  std::ifstream file(in_source("configs/sim_handheld.yaml"));
  const std::string yaml(std::istreambuf_iterator<char>(file), {});
  int inside = 0, all = 0;
  for (std::uint64_t seed = 1; seed <= 4; ++seed)
    test::run_simulated(yaml, {}, seed, [&](const sim::SimulatedSample& truth, const Processed& out) {
      if (in_seconds(truth.sample.t_ns) < 150.0) return;
      const fusion::AttitudeEstimate& e = out.attitude;
      ++all;
      inside += test::world_error(truth, out).head<2>().norm() < 3.0 * std::max(e.sigma_roll_rad, e.sigma_pitch_rad);
    });
  EXPECT_GT(inside, 0.98 * all);
}

}  // namespace
}  // namespace stillpoint::pipeline
