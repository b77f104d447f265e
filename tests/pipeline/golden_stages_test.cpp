/// What a subscriber is told and what is learnt, through all stages, of a sensor whose every fault has its minute. What
/// the daemon has to do about each is asked elsewhere; here a figure that is another one shows.
#include <gtest/gtest.h>

#include <iomanip>
#include <limits>

#include "core/units.h"
#include "tests/golden.h"
#include "tests/pipeline/simulated_run.h"

namespace stillpoint::pipeline {
namespace {

using test::within;

constexpr char kSensor[] =
    "rate_hz: 100\n"
    "accelerometer: {noise_mps2: 0.03, bias: [0.12, -0.1, 0.2], matrix: [[1.01, 0, 0], [0, 0.99, 0.004], [0, 0, 1]]}\n"
    "gyroscope: {noise_radps: 0.002, bias: [0.02, -0.015, 0.03], matrix: [[1.008, 0, 0.002], [0, 0.99, 0], [0, 0, "
    "1]]}\n"
    "magnetometer: {noise_uT: 0.4, bias: [12, -6, 10], matrix: [[1.03, 0, 0], [0, 0.98, 0], [0, 0.01, 1]]}\n"
    "motion: {kind: hand, duration_s: 400}\n";

std::string line(const Processed& out, const Stages& stages) {
  std::ostringstream text;
  text << std::fixed << std::setprecision(6);
  const auto put = [&text](const auto& values) {
    for (const auto& x : values) text << x << ' ';
  };
  const AttitudeMessage m = to_message(out);
  text << in_seconds(m.t_ns) << ' ' << m.sequence << ' ' << m.calibration_version << ' ';
  put(m.q_world_body_xyzw);
  put(m.rate_radps);
  put(m.gyro_bias_radps);
  put(m.sigma_rpy_rad);
  text << m.temp_degC << ' ' << m.at_rest << ' ' << static_cast<int>(m.status) << ' '
       << static_cast<int>(m.heading_reference) << ' ';
  for (const SensorHealth& h : {m.health.acc, m.health.gyr, m.health.mag, m.health.temp})
    text << static_cast<int>(h.state) << ' ' << static_cast<int>(h.fault) << ' ' << in_seconds(h.since_ns) << ' ';
  const CalibrationSnapshot& learnt = stages.live();
  for (const TriadCalibration& t : {learnt.acc, learnt.gyr, learnt.mag}) {
    put(t.bias);
    put(t.matrix);
    text << t.windows << ' ' << static_cast<int>(t.status) << ' ';
  }
  const StagesCounts& counts = stages.counts();
  text << counts.windows << ' ' << counts.answers_late << ' ' << counts.gate_refused << ' '
       << stages.guard().counts().gaps << '\n';
  return text.str();
}

/// Every fourth second a line. `change(t_s, sample)` spoils a reading; false: it never came.
template <class Change>
std::string trace_of(const StagesParams& params, const Change& change) {
  test::GoldenTrace trace{4'000'000'000};
  test::run_spoiled(
      kSensor, params, 5, [&change](RawSample& s) { return change(in_seconds(s.t_ns), s); },
      [&trace](const sim::SimulatedSample&, const Processed& out, const Stages& stages) {
        trace.add(out.attitude.t_ns, [&] { return line(out, stages); });
      });
  return trace.text;
}

TEST(GoldenStages, ASoundSensorIsLearnt) {
  test::check_golden("stages_sound", trace_of({}, [](double t_s, RawSample& s) {
                       s.temp_degC = 22.0 + 0.02 * t_s;
                       s.has |= kTemp;
                       return true;
                     }));
}

TEST(GoldenStages, EveryFaultHasItsMinute) {
  RawSample held;
  StagesParams params;
  params.guard.acc_limit_mps2 = 30.0;
  test::check_golden("stages_faults", trace_of(params, [&held](double t_s, RawSample& s) {
                       if (within(t_s, 60.0, 64.0)) s.gyr_radps = held.gyr_radps;
                       if (within(t_s, 90.0, 94.0)) s.acc_mps2[1] = held.acc_mps2[1];
                       if (within(t_s, 120.0, 124.0)) s.mag_uT = held.mag_uT;
                       if (within(t_s, 150.0, 154.0)) s.gyr_radps[0] *= -1.0;
                       if (within(t_s, 180.0, 184.0)) vec(s.acc_mps2) *= 2.0;
                       if (within(t_s, 210.0, 210.5)) s.gyr_radps[2] = std::numeric_limits<double>::quiet_NaN();
                       if (within(t_s, 225.0, 225.1)) s.gyr_radps[1] = 300.0;
                       if (within(t_s, 240.0, 243.0)) return false;
                       if (within(t_s, 260.0, 262.0)) s.has = kGyr | kMag;
                       if (within(t_s, 280.0, 282.0)) s.acc_mps2 = {35.0, 0.0, 0.0};
                       if (within(t_s, 300.0, 308.0)) vec(s.mag_uT) += Vec3(80.0, 0.0, -40.0);
                       if (within(t_s, 330.0, 334.0)) s.acc_mps2 = {0.0, 0.0, 0.0};
                       if (t_s > 350.0) vec(s.gyr_radps) += Vec3(0.017, 0.0, 0.0);
                       held = s;
                       return true;
                     }));
}

}  // namespace
}  // namespace stillpoint::pipeline
