/// The catalogue, third part: clock, transport and hub of the whole sensor block, and the reference it is held against.
#include "simulation/effect_families.h"

namespace stillpoint::sim {

std::vector<Family> families_of_the_system() {
  return {
      Family("offset", "time offset of all sensors to the reference", "u(t) = true(t-tau)")
          .driven_by("all derivatives", "motion")
          .mistaken_for("delay of one sensor", "acc, gyr and mag give the same tau")
          .takes("tau_s", "tau", "s", 1)
          .in("sys", "T1", 1e-3, 5e-2),
      Family("skew", "clock rate error", "u(t) = true(t + 1e-6 int (eps + k (T-T0)) dt)")
          .driven_by("time times derivatives", "long recording")
          .mistaken_for("sys_gap, sys_offset", "grows linearly, or as the temperature bends it; no jump")
          .takes("eps_ppm", "eps", "ppm", 1)
          .may_take("k_ppm_per_K", "k", "ppm/K", 1, 0.0)
          .in("sys", "T3", 5, 1e4),
      Family("gap", "lost samples, time stamps regenerated", "u(t) = true(t + n/fs) where t > t0")
          .driven_by("derivatives after t0", "bus overload")
          .mistaken_for("sys_skew, sys_offset", "a jump, in all sensors at once")
          .takes("n", "n", "samples", 1)
          .takes("t0_s", "t0", "s", 1)
          .in("sys", "T4", 1, 50),
      Family("dup", "lost samples replaced by the last", "u_k = u_{k-1} at random")
          .driven_by("derivatives", "radio")
          .mistaken_for("mag_hold, bursts of noise", "exact repeats in all sensors at the same sample")
          .takes("fraction", "fraction", "1", 1)
          .in("sys", "T5", 1e-4, 0.02),
      Family("jitter", "jitter", "u(t + d), d random")
          .driven_by("derivatives", "fast motion")
          .mistaken_for("noise that grows with motion", "residual variance proportional to the squared derivative")
          .takes("sd_s", "sd", "s", 1)
          .in("sys", "T6", 1e-5, 2e-3),
      Family("tracker", "bias tracker on board", "u = y - b, b follows the mean at rest with tau")
          .driven_by("pattern of rests", "rest, slow turns")
          .mistaken_for("no thermal effect at all", "the residual steps where rest begins and ends")
          .takes("tau_s", "tau", "s", 1)
          .may_take("limit_radps", "limit", "rad/s", 1, 0.03)
          .in("sys", "T11", 5, 60),
      Family("error", "reference error", "band-limited noise on orientation and position")
          .driven_by("none", "always")
          .mistaken_for("low-pass, resonance, delay of the IMU", "appears at rest too")
          .takes("orientation_sd_rad", "orientation", "rad", 1)
          .takes("position_sd_m", "position", "m", 1, 5e-5, 5e-4)
          .takes("band_hz", "band", "Hz", 1, 5, 20)
          .in("ref", "T13", 3.5e-4, 3.5e-3),
      Family("frame", "reference frame: mount rotation and pivot offset",
             "D = (exp(phi)' - 1) true in all sensors, acc_lever with r")
          .driven_by("attitude, rate", "always")
          .mistaken_for("wrong H in acc, gyr and mag together", "one common rotation")
          .takes("phi_rad", "phi", "rad", 3)
          .may_take("r_m", "r", "m", 3, 0.0)
          .in("ref", "T14", 0.01, 0.09),
  };
}

}  // namespace stillpoint::sim
