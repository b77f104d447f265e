/// The catalogue, second part: effects that only one sensor has.
#include "simulation/effect_families.h"

namespace stillpoint::sim {
namespace {

std::vector<Family> of_the_accelerometer() {
  return {
      Family("lever", "lever arm", "D = dw/dt x r + w x (w x r)")
          .driven_by("angular acceleration and rate", "fast rotation")
          .mistaken_for("acc_size, translation", "Euler and centripetal part with one common r")
          .takes("r_m", "r", "m", 3)
          .in("acc", "A5", 0.005, 0.3),
      Family("size", "size effect: each axis senses at its own point", "D_i = [dw/dt x r_i + w x (w x r_i)]_i")
          .driven_by("angular acceleration and rate", "fast rotation")
          .mistaken_for("acc_lever", "three different r")
          .takes("r_m", "r", "m", 9)
          .in("acc", "A6", 0.001, 0.008),
      Family("quad", "even nonlinearity", "D = k2 * f^2")
          .driven_by("specific force squared", "more than 2 g, both signs")
          .mistaken_for("acc_vre, offset", "the same coefficient in slow motion and in vibration")
          .takes("k2_per_mps2", "k2", "1/(m/s^2)", 3)
          .in("acc", "A7", 5e-6, 4e-4),
      Family("resonance", "resonance of sensor or mount", "D = h(f) - f, h = wn^2/(s^2 + 2 zeta wn s + wn^2)")
          .driven_by("specific force", "broadband motion, shocks")
          .mistaken_for("low-pass, delay, vibration", "gain above 1 below f_n; ringing after shocks")
          .takes("f_hz", "f_n", "Hz", 1)
          .takes("zeta", "zeta", "1", 1, 0.02, 0.2)
          .in("acc", "A12", 10, 200),
      Family("gravity", "local gravity error", "D = dg R' e_z")
          .driven_by("attitude", "always")
          .mistaken_for("isotropic scale error of H", "separates only through translation")
          .takes("dg_mps2", "dg", "m/s^2", 1)
          .in("acc", "A15", 0.001, 0.026),
  };
}

std::vector<Family> of_the_gyroscope() {
  return {
      Family("gsens", "acceleration sensitivity", "D = G f")
          .driven_by("specific force", "tilting at rest, linear acceleration")
          .mistaken_for("offset, Earth rotation", "depends on attitude at rest and follows acceleration in motion")
          .takes("G_radps_per_mps2", "G", "rad/s per m/s^2", 9)
          .in("gyr", "G5", 3e-5, 1.8e-4),
      Family("earth", "Earth rotation", "D = R' w; where w is not given, scale 7.292e-5 (0, cos lat, sin lat)")
          .driven_by("attitude", "attitude changes, long rest")
          .mistaken_for("offset, gyr_gsens", "fixed in the world, size known")
          .may_take("scale", "scale", "1", 1, 1.0)
          .may_take("w_radps", "w", "rad/s", 3, 0.0)
          .in("gyr", "G12"),
      Family("instability", "bias instability", "1/f floor, Allan deviation 0.664 b")
          .driven_by("none", "long rest")
          .mistaken_for("gyr_drift, thermal", "Allan slope 0")
          .takes("b_radps", "b", "rad/s", 3)
          .in("gyr", "G13", 1e-5, 1e-4),
      Family("coning", "coning of the integration",
             "D_i = pi f a_j a_k sin(p_j-p_k), and the line a_i 2 pi f cos(2 pi f t + p_i)")
          .driven_by("phase-locked oscillation on two axes", "coning near half the sampling rate")
          .mistaken_for("drift in vibration", "falls with a higher rate")
          .takes("a_rad", "a", "rad", 3)
          .takes("f_hz", "f", "Hz", 1, 10, 500)
          .takes("p_rad", "p", "rad", 3, 0, 3.2)
          .in("gyr", "G15", 1e-4, 1e-2),
      Family("deadzone", "dead zone", "y = 0 where |y| < d")
          .driven_by("the reading itself", "slow rotation")
          .mistaken_for("quantisation", "values exactly 0; slow turns are lost")
          .takes("d_radps", "d", "rad/s", 3)
          .in("gyr", "T8", 1.7e-3, 1.7e-2),
  };
}

std::vector<Family> of_the_magnetometer() {
  return {
      Family("hard_step", "hard iron appears", "D = b where t > t0")
          .driven_by("time", "battery, tool, door")
          .mistaken_for("mag_field_step", "stays in the body frame when turning")
          .takes("b_uT", "b", "uT", 3)
          .takes("t0_s", "t0", "s", 1)
          .in("mag", "M3", 0.5, 50),
      Family("soft_step", "soft iron appears", "D = M m where t > t0")
          .driven_by("time, field", "steel part added")
          .mistaken_for("mag_hard_step, mag_field_step", "ellipsoid before and after")
          .takes("M", "M", "1", 9)
          .takes("t0_s", "t0", "s", 1)
          .in("mag", "M4", 0.005, 0.1),
      Family("field_step", "ambient field changes", "D = R' b where t > t0")
          .driven_by("time", "vehicle, lift, room")
          .mistaken_for("mag_hard_step", "stays in the world frame when turning; dip and |m| change")
          .takes("b_world_uT", "b_w", "uT", 3)
          .takes("t0_s", "t0", "s", 1)
          .in("mag", "M5", 0.5, 50),
      Family("gradient", "field varies with position", "D = R' (G p + b)")
          .driven_by("position", "walking, near steel")
          .mistaken_for("mag_field_step, lever arm", "returns when the position returns")
          .takes("G_uT_per_m", "G", "uT/m", 9)
          .may_take("b_world_uT", "b", "uT", 3, 0.0)
          .in("mag", "M6", 1, 50),
      Family("current", "field of a current", "D = k I")
          .driven_by("current", "motors, charging")
          .mistaken_for("mag_hard_step, temperature", "follows I within a sample; body frame")
          .takes("k_uT_per_A", "k", "uT/A", 3)
          .in("mag", "M7", 0.1, 5),
      Family("line", "line interference, aliased", "D = b sin(2 pi f t + phase)")
          .driven_by("time", "mains, motors")
          .mistaken_for("noise", "sharp line; moves when the rate changes")
          .takes("b_uT", "b", "uT", 3)
          .takes("f_hz", "f", "Hz", 1, 1, 400)
          .may_take("phase_rad", "phase", "rad", 1, 0.0)
          .in("mag", "M8", 0.05, 2),
      Family("hold", "stale hold: a slower magnetometer, repeated", "y_k = y_{n floor(k/n)}")
          .driven_by("rate of change of the field", "rotation")
          .mistaken_for("mag_delay, low-pass, quantisation", "exact repeats with a fixed period")
          .takes("n", "n", "samples", 1)
          .in("mag", "M9", 2, 20),
      Family("sat", "saturation, nonlinearity", "y = clip(y, +-L), D = k3 * m^3")
          .driven_by("the reading itself", "near magnets")
          .mistaken_for("mag_hard_step", "only near strong field")
          .takes("L_uT", "L", "uT", 3)
          .may_take("k3_per_uT_2", "k3", "1/uT^2", 3, 0.0)
          .may_take("side", "side", "1: only above, -1: only below, 0: both", 3, 0.0)
          .in("mag", "M12", 800, 5000),
      Family("flip", "polarity flip", "D = b (-1)^k")
          .driven_by("sample parity", "after strong field")
          .mistaken_for("mag_hard_step", "parity")
          .takes("b_uT", "b", "uT", 3)
          .in("mag", "M13", 1, 50),
  };
}

}  // namespace

std::vector<Family> families_of_one_sensor() {
  std::vector<Family> all = of_the_accelerometer();
  for (const auto& part : {of_the_gyroscope(), of_the_magnetometer()}) all.insert(all.end(), part.begin(), part.end());
  return all;
}

}  // namespace stillpoint::sim
