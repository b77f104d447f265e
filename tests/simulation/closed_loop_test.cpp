/// Closed loops on the readings themselves, by a navigator written here: what an ideal sensor gives, integrated, comes
/// back to the true attitude, velocity and place.
#include <gmock/gmock.h>

#include "core/so3.h"
#include "io/simulation_yaml.h"
#include "simulation/simulator.h"

namespace stillpoint::sim {
namespace {

constexpr double kLoopRate_hz = 2000.0;

/// An ideal sensor: no noise, no effect; H and B are not trivial and are taken off as a user takes them off.
SimulationConfig ideal(const std::string& kind, const std::string& effects = "") {
  auto c = *io::parse_simulation(
      "rate_hz: 2000\n"
      "accelerometer: {bias: [0.1, -0.2, 0.3], matrix: [[1.1, 0.02, 0], [0, 0.9, 0.03], [0.01, 0, 1.05]]}\n"
      "gyroscope: {bias: [0.01, 0, -0.02], matrix: [[0.98, 0, 0.01], [0, 1.03, 0], [0, 0.02, 1]]}\n"
      "motion: {kind: " +
          kind + ", duration_s: 30, vibration_hz: 60}\n" + effects,
      "test");
  return c;
}

struct Ends {
  double attitude_rad, velocity_mps, position_m;
};

/// Two rows a step: the middle one is the half step of fourth-order Runge-Kutta on dq/dt = q w / 2, dv/dt = q f - g,
/// dp/dt = v. At 2000 Hz and 20 rad/s of bandwidth a step leaves (20 * 0.001)^5 / 120 rad, 1e-8 in all.
Ends navigate(const SimulationConfig& c, double from_s, double to_s) {
  const std::shared_ptr<const Motion> motion = make_motion(*c.motion, 6);
  const auto rows = simulate(c, motion, 6);
  const auto start = static_cast<std::size_t>(from_s * kLoopRate_hz),
             end = static_cast<std::size_t>(to_s * kLoopRate_hz);
  const double h = 2.0 / kLoopRate_hz;
  const Vec3 gravity(0.0, 0.0, c.gravity_mps2);
  Quat q = rows[start].true_q_world_body;
  Vec3 v = motion->at(from_s).velocity_mps, p = rows[start].true_position_m;
  const auto rate = [&](std::size_t k) {
    return Vec3(c.gyroscope->matrix * (vec(rows[k].sample.gyr_radps) - c.gyroscope->bias));
  };
  const auto pull = [&](const Quat& at, std::size_t k) {
    return Vec3(at * (c.accelerometer->matrix * (vec(rows[k].sample.acc_mps2) - c.accelerometer->bias)) - gravity);
  };
  const auto slope = [](const Quat& at, const Vec3& w) {
    return Eigen::Vector4d(0.5 * (at * Quat(0.0, w.x(), w.y(), w.z())).coeffs());
  };
  const auto moved = [](const Quat& from, const Eigen::Vector4d& by) {
    return Quat(Eigen::Vector4d(from.coeffs() + by)).normalized();
  };
  for (std::size_t k = start; k < end; k += 2) {
    const Eigen::Vector4d k1 = slope(q, rate(k)), k2 = slope(moved(q, 0.5 * h * k1), rate(k + 1));
    const Eigen::Vector4d k3 = slope(moved(q, 0.5 * h * k2), rate(k + 1)), k4 = slope(moved(q, h * k3), rate(k + 2));
    const Quat last = moved(q, h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4));
    const Eigen::Vector4d half_way =  // Hermite's cubic through both ends
        0.5 * (q.coeffs() + last.coeffs()) + h / 8.0 * (slope(q, rate(k)) - slope(last, rate(k + 2)));
    const Quat middle = Quat(half_way).normalized();
    const Vec3 a = pull(q, k), b = pull(middle, k + 1), d = pull(last, k + 2);
    p += h * v + h * h / 6.0 * (a + 2.0 * b);
    v += h / 6.0 * (a + 4.0 * b + d);
    q = last;
  }
  return {log_quat(q.conjugate() * rows[end].true_q_world_body).norm(), (v - motion->at(to_s).velocity_mps).norm(),
          (p - rows[end].true_position_m).norm()};
}

class ClosedLoop : public ::testing::TestWithParam<std::string> {};

/// Position hears the attitude's error through gravity: 1e-8 rad would be 2e-5 m after 20 s, so 1e-5 m asks more of the
/// attitude than 1e-6 rad does.
TEST_P(ClosedLoop, ReadingsIntegrateBackToAttitudeAndPosition) {
  const Ends ends = navigate(ideal(GetParam()), 2.0, 22.0);
  EXPECT_LT(ends.attitude_rad, 1e-6);
  EXPECT_LT(ends.velocity_mps, 1e-5);
  EXPECT_LT(ends.position_m, 1e-5);
}

INSTANTIATE_TEST_SUITE_P(Kinds, ClosedLoop, ::testing::Values("hand", "tumble", "walking", "drone", "boat", "vehicle"),
                         [](const auto& i) { return i.param; });

/// The loop closes because the signs and frames are right, not because it would close on anything: Earth rotation in
/// the readings opens it by its own angle, a lever arm by its own length.
TEST(ClosedLoop, OpensByWhatAnEffectAdds) {
  const Ends earth = navigate(ideal("hand", "effects: [{effect: gyr_earth}]\n"), 2.0, 22.0);
  EXPECT_NEAR(earth.attitude_rad, 7.292115e-5 * 20.0, 1e-6);
  const Ends gravity = navigate(ideal("hand", "effects: [{effect: acc_gravity, dg_mps2: 0.01}]\n"), 2.0, 22.0);
  EXPECT_NEAR(gravity.position_m, 0.5 * 0.01 * 400.0, 1e-4);
  EXPECT_LT(gravity.attitude_rad, 1e-6);
}

}  // namespace
}  // namespace stillpoint::sim
