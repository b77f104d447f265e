#include "simulation/continuous_motion.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/units.h"
#include "simulation/random.h"

namespace stillpoint::sim {
namespace {

/// A motion whose path is a function object over Taylor time.
template <class Path>
class FormulaMotion final : public Motion {
 public:
  FormulaMotion(double duration_s, Path path) : duration_s_(duration_s), path_(std::move(path)) {}
  [[nodiscard]] MotionState at(double t_s) const noexcept override { return path_(Taylor::time(t_s)); }
  [[nodiscard]] double duration_s() const noexcept override { return duration_s_; }

 private:
  double duration_s_;
  Path path_;
};

template <class Path>
std::unique_ptr<Motion> formula(double duration_s, Path path) {
  return std::make_unique<FormulaMotion<Path>>(duration_s, std::move(path));
}

Taylor wave(double amplitude, double frequency_hz, double phase, const Taylor& t) {
  return amplitude * sin(kTwoPi * frequency_hz * t + phase);
}

TaylorQuat turn(int axis, const Taylor& angle) {
  TaylorVec phi;
  phi.at[static_cast<std::size_t>(axis)] = angle;
  return exp_quat(phi);
}

TaylorQuat yaw_pitch_roll(const Taylor& yaw, const Taylor& pitch, const Taylor& roll) {
  return turn(2, yaw) * turn(1, pitch) * turn(0, roll);
}

/// Integral of smooth_step: u^5 (7 - 14 u + 10 u^2 - 2.5 u^3) for u in [0, 1], then u - 1/2.
Taylor smooth_ramp(const Taylor& u) {
  if (u.x <= 0.0) return {};
  if (u.x >= 1.0) return u - 0.5;
  const double v = u.x;
  const Taylor step = smooth_step({v, 1.0, 0.0});
  return chain(u, v * v * v * v * v * (7.0 + v * (-14.0 + v * (10.0 - 2.5 * v))), step.x, step.d);
}

/// Distance covered when the speed rises from 0 to 1 within `ramp`, holds, and falls to 0 again, all within `length`.
Taylor trapezoid(const Taylor& t, double ramp, double length) {
  return ramp * (smooth_ramp((1.0 / ramp) * t) - smooth_ramp((1.0 / ramp) * (t - (length - ramp))));
}

}  // namespace

std::unique_ptr<Motion> make_turntable(const MotionConfig& c, std::uint64_t) {
  const double run_s = c.max_bout_s, period_s = run_s + c.max_rest_s + c.move_s;
  const double rate = c.rate_radps, move_s = c.move_s, rest_s = c.max_rest_s;
  // Rest, a run at constant rate about one body axis, then the table is tilted for the next axis; signs alternate.
  return formula(c.duration_s, [=](const Taylor& t) {
    const double index = std::max(0.0, std::floor(t.x / period_s));
    const Taylor u = t - index * period_s;
    const int axis = static_cast<int>(std::fmod(index, 3.0));
    const double sign = std::fmod(index, 2.0) == 0.0 ? 1.0 : -1.0;
    const double ramp_s = std::min(1.0, 0.25 * run_s), before = sign > 0.0 ? 0.0 : rate * (run_s - ramp_s);
    const Taylor angle = (sign * rate) * trapezoid(u - rest_s, ramp_s, run_s) + before;
    // The vertical is body z, then x, then y: the tilt about (1,1,1) by a third of a turn permutes the axes.
    const Taylor tilt =
        (kTwoPi / 3.0) * (smooth_step((1.0 / move_s) * (u - (rest_s + run_s))) + static_cast<double>(axis));
    TaylorVec permute;
    permute.add(Vec3::Constant(-1.0 / std::sqrt(3.0)), tilt);
    const bool moving = u.x > rest_s && u.x < period_s;
    return motion_state({}, turn(2, angle) * exp_quat(permute), moving);
  });
}

std::unique_ptr<Motion> make_tumble(const MotionConfig& c, std::uint64_t seed) {
  Stream random(seed, "motion tumble");
  std::array<double, 3> phase{};
  for (auto& p : phase) p = random.uniform(0.0, kTwoPi);
  const double rate = c.rate_radps, sway = c.sway_m;
  return formula(c.duration_s, [=](const Taylor& t) {
    const TaylorQuat q =
        yaw_pitch_roll(rate * t + phase[0], (0.618 * rate) * t + phase[1], (1.414 * rate) * t + phase[2]);
    TaylorVec p;
    p.at = {wave(sway, 0.31, phase[1], t), wave(sway, 0.23, phase[2], t), wave(sway, 0.17, phase[0], t)};
    return motion_state(p, q, true);
  });
}

std::unique_ptr<Motion> make_walking(const MotionConfig& c, std::uint64_t seed) {
  Stream random(seed, "motion walking");
  const double step_hz = random.uniform(1.7, 2.1), speed = std::min(c.speed_mps, 1.4);
  const double start_s = c.max_rest_s, length_s = std::max(4.0, c.duration_s - 2.0 * c.max_rest_s);
  return formula(c.duration_s, [=](const Taylor& t) {
    const Taylor size = smooth_step(t - start_s) * smooth_step(-t + (start_s + length_s));
    const Taylor stride = kTwoPi * step_hz * (t - start_s);
    // Heel strike: a narrow smooth bump once a step (von Mises shape); 2e-4 m of it give about 20 m/s^2.
    const Taylor strike = 2e-4 * exp(60.0 * (cos(stride) - 1.0));
    TaylorVec p;
    p.at[0] = speed * trapezoid(t - start_s, 1.0, length_s) + size * (0.015 * sin(stride));
    p.at[1] = size * (0.025 * sin(0.5 * stride));
    p.at[2] = size * (0.025 * cos(stride) + strike);
    const TaylorQuat q = yaw_pitch_roll(size * (0.08 * sin(0.5 * stride)), size * (0.03 * sin(stride + 0.6)),
                                        size * (0.04 * sin(0.5 * stride + 1.1)));
    return motion_state(p, q, t.x > start_s && t.x < start_s + length_s);
  });
}

std::unique_ptr<Motion> make_vehicle(const MotionConfig& c, std::uint64_t seed) {
  Stream random(seed, "motion vehicle");
  const double radius_m = std::max(30.0, c.speed_mps * c.speed_mps / 2.5), ramp_s = std::max(4.0, c.speed_mps / 2.0);
  const double drive_s = 2.0 * ramp_s + 4.0 * c.max_bout_s, period_s = drive_s + c.max_rest_s;
  const double whole_m = c.speed_mps * (drive_s - ramp_s);
  const double engine_hz = 0.2 * c.vibration_hz, engine_m = 0.02 * c.vibration_mps2 / std::pow(kTwoPi * engine_hz, 2);
  const double rest_s = c.max_rest_s, speed = c.speed_mps, phase = random.uniform(0.0, kTwoPi);
  // Standing (engine idling), pulling away, cruising on a wide circle that leans outwards, braking to a stand.
  return formula(c.duration_s, [=](const Taylor& t) {
    const double index = std::max(0.0, std::floor(t.x / period_s));
    const Taylor u = t - (index * period_s + rest_s);
    const Taylor along = speed * trapezoid(u, ramp_s, drive_s) + index * whole_m;
    const Taylor heading = (1.0 / radius_m) * along;
    const Taylor size = smooth_step(0.5 * u) * smooth_step(0.5 * (-u + drive_s));
    TaylorVec p;
    p.at[0] = radius_m * sin(heading);
    p.at[1] = -radius_m * cos(heading) + radius_m;
    p.at[2] = wave(engine_m, engine_hz, phase, t) + size * (wave(0.01, 1.3, phase, t) + wave(0.0005, 11.0, 1.0, t));
    const TaylorQuat q =
        yaw_pitch_roll(heading, size * wave(0.01, 0.9, 0.4, t), size * (wave(0.008, 1.1, phase, t) + 0.03));
    return motion_state(p, q, u.x > 0.0 && u.x < drive_s);
  });
}

std::unique_ptr<Motion> make_boat(const MotionConfig& c, std::uint64_t seed) {
  Stream random(seed, "motion boat");
  std::array<double, 8> phase{};
  for (auto& p : phase) p = random.uniform(0.0, kTwoPi);
  const double sway = c.sway_m;
  // At anchor: never at rest, only slow. The sea has a dominant period of about 5 s and a slower swell.
  return formula(c.duration_s, [=](const Taylor& t) {
    const Taylor roll = wave(0.06, 0.21, phase[0], t) + wave(0.02, 0.083, phase[1], t);
    const Taylor pitch = wave(0.03, 0.19, phase[2], t) + wave(0.01, 0.31, phase[3], t);
    const Taylor yaw = wave(0.15, 0.013, phase[4], t);
    TaylorVec p;
    p.at = {wave(8.0 * sway, 0.05, phase[5], t), wave(6.0 * sway, 0.06, phase[6], t),
            wave(4.0 * sway, 0.18, phase[7], t)};
    return motion_state(p, yaw_pitch_roll(yaw, pitch, roll), true);
  });
}

std::unique_ptr<Motion> make_drone(const MotionConfig& c, std::uint64_t seed) {
  Stream random(seed, "motion drone");
  std::array<double, 9> phase{};
  for (auto& p : phase) p = random.uniform(0.0, kTwoPi);
  const double start_s = c.max_rest_s, length_s = std::max(5.0, c.duration_s - 2.0 * c.max_rest_s);
  const double shake_m = c.vibration_mps2 / std::pow(kTwoPi * c.vibration_hz, 2), f = c.vibration_hz;
  const double reach_m = 0.3 * c.speed_mps;
  return formula(c.duration_s, [=](const Taylor& t) {
    const Taylor size = smooth_step(0.5 * (t - start_s)) * smooth_step(0.5 * (-t + (start_s + length_s)));
    TaylorVec p;
    p.at[0] = size * (wave(reach_m, 0.07, phase[0], t) + wave(shake_m, f, phase[1], t));
    p.at[1] = size * (wave(reach_m, 0.05, phase[2], t) + wave(shake_m, f, phase[3], t));
    p.at[2] = size * (wave(0.3 * reach_m, 0.04, phase[4], t) + wave(0.7 * shake_m, 2.0 * f, phase[5], t)) + 2.0 * size;
    const TaylorQuat q = yaw_pitch_roll(size * wave(1.2, 0.03, phase[6], t),
                                        size * (wave(0.12, 0.3, phase[7], t) + wave(2e-4, f, 0.5, t)),
                                        size * (wave(0.12, 0.37, phase[8], t) + wave(2e-4, f, 1.5, t)));
    return motion_state(p, q, t.x > start_s && t.x < start_s + length_s);
  });
}

}  // namespace stillpoint::sim
