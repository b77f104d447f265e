/// Replays through everything that sensors do wrong: the golden recordings are sound, and most of the filter's lines
/// are for those that are not. What each of them has to do is asked elsewhere; here a figure that is another one shows.
#include <gtest/gtest.h>

#include <iomanip>
#include <limits>

#include "core/units.h"
#include "fusion/attitude_filter.h"
#include "tests/fusion/random_motion.h"
#include "tests/golden.h"

namespace stillpoint::fusion {
namespace {

using test::MotionParams;
using test::RandomMotion;
using test::within;

std::string whole_line(const AttitudeEstimate& e) {
  std::ostringstream out;
  out << std::fixed << std::setprecision(6) << in_seconds(e.t_ns);
  for (const double x : e.q_world_body) out << ' ' << x;
  for (const double x : {e.sigma_roll_rad, e.sigma_pitch_rad, e.sigma_yaw_rad}) out << ' ' << x;
  for (const double x : e.rate_body_radps) out << ' ' << x;
  for (const double x : e.gyro_bias_sd_radps) out << ' ' << x;
  for (const int x : {static_cast<int>(e.heading), static_cast<int>(e.status), int{e.gyro_offset_jumped},
                      int{e.acc_offset_jumped}, int{e.denied}, int{e.refused}})
    out << ' ' << x;
  out << '\n';
  return out.str();
}

/// Twenty seconds a round, of which the body rests five; every second a line. `change(t_s, sample)` spoils a
/// reading; false: it never came.
template <class Change>
std::string trace_of(AttitudeFilter& filter, const MotionParams& params, double duration_s, const Change& change) {
  RandomMotion motion(params, 3);
  test::GoldenTrace trace{1'000'000'000};
  for (int i = 0; i < static_cast<int>(duration_s * params.rate_hz); ++i) {
    const double t_s = i / params.rate_hz, in_round_s = std::fmod(t_s, 20.0);
    CalibratedSample s = motion.next(in_round_s < 5.0);
    if (!change(t_s, s)) continue;
    const AttitudeEstimate e = filter.step(s, in_round_s > 0.5 && in_round_s < 5.0);
    trace.add(e.t_ns, [&e] { return whole_line(e); });
  }
  return trace.text;
}

TEST(GoldenFaults, Silences) {
  AttitudeFilter filter;
  test::check_golden(
      "silences", trace_of(filter, {}, 140.0, [](double t_s, CalibratedSample& s) {
        if (t_s < 0.3) vec(s.acc_mps2) *= 0.01;  // falling: no down yet
        if (within(t_s, 26.0, 29.0)) s.has = kAcc | kMag;
        if (within(t_s, 32.0, 35.0)) s.has = kGyr | kMag, s.absent = kAcc;
        if (within(t_s, 42.0, 60.0) && s.sequence % 4 != 0) s.has = kGyr;  // they only speak more rarely
        for (const auto& [at_s, long_s] : {std::pair{28.0, 0.06}, {48.0, 0.2}, {52.0, 1.0}, {68.0, 8.0}, {90.0, 30.0}})
          if (within(t_s, at_s, at_s + long_s)) return false;
        if (within(t_s, 76.0, 76.5) || within(t_s, 120.0, 121.0)) s.has = kAcc;  // back, but not all at once
        return true;
      }));
}

TEST(GoldenFaults, RailsRepetitionsAndLines) {
  AttitudeFilter filter;
  CalibratedSample held;
  test::check_golden("rails", trace_of(filter, {}, 100.0, [&held](double t_s, CalibratedSample& s) {
                       const auto cut = [&s](Array3& reading, double limit, SamplePart part) {
                         for (double& x : reading) {
                           if (std::abs(x) < limit) continue;
                           x = std::copysign(limit, x);
                           s.clipped = static_cast<std::uint8_t>(s.clipped | part);
                         }
                       };
                       if (within(t_s, 26.0, 30.0)) cut(s.gyr_radps, 0.8, kGyr);
                       if (within(t_s, 32.0, 36.0)) cut(s.acc_mps2, 10.5, kAcc);
                       if (within(t_s, 38.0, 39.0)) cut(s.mag_uT, 30.0, kMag);
                       if (within(t_s, 46.0, 48.5)) s.gyr_radps = held.gyr_radps;
                       if (within(t_s, 50.0, 52.5)) s.acc_mps2 = held.acc_mps2;
                       if (within(t_s, 54.0, 55.0))
                         for (double& x : s.gyr_radps) x = 0.3 * (t_s - 54.0);  // drawn as a line
                       if (within(t_s, 66.0, 66.3)) s.gyr_radps[1] = std::numeric_limits<double>::quiet_NaN();
                       if (within(t_s, 68.0, 68.3)) s.acc_mps2[2] = std::numeric_limits<double>::infinity();
                       if (within(t_s, 70.0, 70.3)) s.gyr_radps[0] = 2e3;
                       if (within(t_s, 72.0, 78.0)) s.mag_uT = held.mag_uT;
                       if (within(t_s, 90.0, 90.1)) s.t_ns -= 1'000'000'000;
                       held = s;
                       return true;
                     }));
}

TEST(GoldenFaults, OffsetsThatJump) {
  AttitudeFilter filter;
  test::check_golden("offsets", trace_of(filter, {}, 160.0, [](double t_s, CalibratedSample& s) {
                       if (t_s > 30.0) vec(s.gyr_radps) += Vec3(0.02, -0.015, 0.01);
                       if (t_s > 61.0) vec(s.gyr_radps) += Vec3(-0.05, 0.03, 0.06);  // at rest
                       if (t_s > 90.0) vec(s.acc_mps2) += Vec3(1.5, -1.2, 0.4);
                       if (t_s > 110.0) vec(s.mag_uT) += Vec3(40.0, -60.0, 20.0);  // a magnet on the body
                       return true;
                     }));
}

TEST(GoldenFaults, AxesThatAreOthers) {
  AttitudeFilter filter;
  test::check_golden("axes", trace_of(filter, {}, 140.0, [](double t_s, CalibratedSample& s) {
                       if (within(t_s, 28.0, 36.0)) s.gyr_radps[0] *= -1.0;
                       if (within(t_s, 68.0, 76.0)) std::swap(s.acc_mps2[0], s.acc_mps2[2]);
                       if (within(t_s, 108.0, 116.0)) s.mag_uT[1] *= -1.0;
                       if (within(t_s, 126.0, 132.0)) vec(s.mag_uT) += Vec3(0.0, 30.0, 0.0);
                       return true;
                     }));
}

TEST(GoldenFaults, ACarThatIsNoHand) {
  MotionParams car;
  car.speed_mps = 12.0;
  car.speed_time_s = 5.0;
  car.turn_radps = 0.1;
  car.deviation_rad = 0.1;
  AttitudeFilter filter;
  test::check_golden("car", trace_of(filter, car, 100.0, [](double, CalibratedSample&) { return true; }));
}

TEST(GoldenFaults, EveryOptionIsAnotherOne) {
  AttitudeFilterParams params;
  params.declination_rad = 0.06;
  params.prediction_s = 0.02;
  params.acc_lag_s = 0.005;
  params.update_period_s = 0.1;
  AttitudeFilter filter(params);
  filter.reset(1.0);
  test::check_golden("options", trace_of(filter, {}, 80.0, [&filter](double t_s, CalibratedSample& s) {
                       s.temp_degC = 20.0 + 0.1 * t_s;
                       s.has |= kTemp;
                       s.acc_turn_rad = {0.001, -0.002, 0.003};
                       s.mag_turn_rad = {-0.004, 0.002, 0.001};
                       if (s.sequence == 3200) filter.use_noise({5e-4, 0.05, 0.4});
                       if (s.sequence != 4800) return true;
                       CalibrationSnapshot from, to;
                       to.gyr.matrix = {1.001, 0.002, 0.0, 0.0, 0.998, 0.001, -0.002, 0.0, 1.003};
                       to.gyr.bias = {0.004, -0.002, 0.001};
                       to.gyr.bias_per_K = {1e-4, -2e-4, 0.0};
                       to.gyr.temp_max_degC = 30.0;
                       to.gyr.temp_min_degC = 20.0;
                       to.acc.status = to.mag.status = CalibrationStatus::kOk;
                       to.acc.norm_sd = 0.02;
                       to.mag.matrix = {1.02, 0.0, 0.01, 0.0, 0.97, 0.0, 0.0, 0.02, 1.01};
                       to.mag.bias = {0.5, -0.4, 0.2};
                       to.mag.bias_covariance = {0.04, 0.0, 0.0, 0.0, 0.05, 0.0, 0.0, 0.0, 0.06};
                       filter.rebase(from, to);
                       return true;
                     }));
}

TEST(GoldenFaults, BackwardsInTime) {
  // Of whoever smooths: forwards to a point, and from there back over the same motion.
  RandomMotion motion({}, 4);
  std::vector<CalibratedSample> samples(3000);
  for (std::size_t i = 0; i < samples.size(); ++i) samples[i] = motion.next(i % 2000 < 500);
  AttitudeFilter filter;
  std::string trace;
  for (std::size_t i = 0; i < samples.size(); ++i) (void)filter.step(samples[i], i % 2000 < 500);
  filter.turn_back();
  for (std::size_t k = 0; k < samples.size(); ++k) {
    CalibratedSample s = samples[samples.size() - 1 - k];
    s.t_ns = samples[k].t_ns;
    vec(s.gyr_radps) *= -1.0;
    const AttitudeEstimate e = filter.step(s, (samples.size() - 1 - k) % 2000 < 500);
    if (k % 100 == 0) trace += whole_line(e);
  }
  test::check_golden("backwards", trace);
}

}  // namespace
}  // namespace stillpoint::fusion
