/// The catalogue, first part: effects that two or three sensors share, each written once.
#include "simulation/effect_families.h"

namespace stillpoint::sim {
namespace {

std::vector<Family> of_temperature_and_supply() {
  return {
      Family("temp_lin", "offset, linear in temperature", "D = k (T-T0)")
          .driven_by("temperature", "warm-up, any temperature change")
          .mistaken_for("wrong B, drift, another slow driver such as supply or current",
                        "T is no straight line in time; cool-down has the same k")
          .takes("k_{u}_per_K", "k", "{U}/K", 3)
          .in("acc", "A1", 0.0015, 0.01)
          .in("gyr", "G1", 9e-5, 1.4e-3)
          .in("mag", "M1", 0.01, 0.5),
      Family("temp_quad", "offset, quadratic in temperature", "D = k1 (T-T0) + k2 (T-T0)^2")
          .driven_by("temperature", "a range of more than 10 K")
          .mistaken_for("{s}_temp_lin over a short range, {s}_temp_lag", "range of T; the slope changes sign")
          .takes("k2_{u}_per_K2", "k2", "{U}/K^2", 3)
          .may_take("k1_{u}_per_K", "k1", "{U}/K", 3, 0.0)
          .in("acc", "A2", 1e-5, 1e-3)
          .in("gyr", "G2", 1e-6, 1e-4),
      Family("temp_scale", "scale factor with temperature", "D = S (T-T0) * {v}")
          .driven_by("temperature times {signal}", "{signal} that changes at different T")
          .mistaken_for("{s}_temp_lin as long as the {signal} stays the same",
                        "the same T at two values of the {signal}")
          .takes("S_per_K", "S", "1/K", 3)
          .in("acc", "A3", 1e-4, 2e-4)
          .in("gyr", "G4", 1e-4, 4e-4)
          .in("mag", "M2", 3e-4, 3e-3),
      Family("temp_lag", "thermal lag", "D = k (T-T_L), tau dT_L/dt = T-T_L")
          .driven_by("temperature change, filtered", "first minutes after power-on, load steps")
          .mistaken_for("{s}_temp_lin, drift", "up- and down-ramp give two branches in D(T)")
          .takes("k_{u}_per_K", "k", "{U}/K", 3)
          .takes("tau_s", "tau", "s", 1, 5, 60)
          .in("acc", "A4", 0.002, 0.01)
          .in("gyr", "G3", 1e-4, 2e-3),
      Family("volt", "supply voltage sensitivity", "D = k (V-V0)")
          .driven_by("supply voltage", "load steps, discharge")
          .mistaken_for("temperature, time, current", "load steps move V at once, T slowly")
          .takes("k_{u}_per_V", "k", "{U}/V", 3)
          .in("acc", "T9", 0.02, 0.1)
          .in("gyr", "T9", 0.002, 0.03),
  };
}

std::vector<Family> of_amplitude_and_vibration() {
  return {
      Family("cubic", "odd nonlinearity", "D = k3 * {v}^3")
          .driven_by("{signal} cubed", "{signal} near full scale")
          .mistaken_for("scale factor, saturation", "smooth curvature, no corner; depends on amplitude")
          .takes("k3_per_{u}_2", "k3", "1/({U})^2", 3)
          .in("acc", "A8", 1e-6, 5e-5)
          .in("gyr", "G7", 1e-5, 5e-4),
      Family("asym", "scale asymmetry", "D = k * |{v}|")
          .driven_by("magnitude of {signal} per axis", "both signs of {v}")
          .mistaken_for("an even nonlinearity, an offset in motion", "slope jumps at zero; independent of amplitude")
          .takes("k", "k", "1", 3)
          .in("acc", "A9", 1e-4, 2e-3)
          .in("gyr", "G8", 1e-4, 2e-3),
      Family("sat", "saturation", "y = clip(y, +-L)")
          .driven_by("the reading itself", "large {signal}: impacts, fast turns")
          .mistaken_for(
              "{s}_cubic, filter",
              "samples pile up at the rail; clipped before the filter (hidden) only a one-sided residual is left")
          .takes("L_{u}", "L", "{U}", 3)
          .may_take("hidden", "hidden", "0 or 1", 1, 0.0)
          .may_take("side", "side", "1: only above, -1: only below, 0: both", 3, 0.0)
          .in("acc", "A10", 19.6, 157)
          .in("gyr", "G9", 4.4, 35),
      Family("vre", "vibration rectification", "D = k * <f_hf^2>")
          .driven_by("high-pass power of specific force", "motors, engines")
          .mistaken_for("an even nonlinearity, temperature, current", "comes and goes with the vibration within 1 s")
          .takes("k_{u/f2}", "k", "{U/f2}", 3)
          .may_take("average_s", "averaging", "s", 1, 0.5)
          .in("acc", "A11", 5e-6, 4e-4)
          .in("gyr", "G6", 1e-6, 1e-5),
      Family("alias", "vibration line, folded about half the sampling rate", "D = b sin(2 pi f t + phase)")
          .driven_by("time", "motors faster than half the sampling rate")
          .mistaken_for("slow drift when f is near a multiple of the sampling rate",
                        "moves when sampling rate or motor speed changes")
          .takes("b_{u}", "b", "{U}", 3)
          .takes("f_hz", "f", "Hz", 1, 30, 1000)
          .may_take("phase_rad", "phase", "rad", 1, 0.0)
          .in("acc", "T10", 0.05, 5)
          .in("gyr", "T10", 0.005, 0.5),
  };
}

std::vector<Family> of_filter_and_converter() {
  return {
      Family("lpf", "low-pass", "D = h({v}) - {v}, h = 1/(1 + tau s)")
          .driven_by("{signal}", "fast motion")
          .mistaken_for("{s}_delay, a resonance", "amplitude loss (w tau)^2/2")
          .takes("tau_s", "tau", "s", 1)
          .in("acc", "A13", 1e-3, 1e-2)
          .in("gyr", "G10", 1e-3, 8e-3),
      Family("delay", "delay of the {name}, or of one of its axes, alone", "D = {v}(t-tau) - {v}(t)")
          .driven_by("rate of change of the {signal}", "motion")
          .mistaken_for("a low-pass or a stale hold of the {name}, sys_offset", "the other sensors give 0")
          .takes("tau_s", "tau", "s", 1)
          .in("acc", "T2", 1e-3, 2e-2)
          .in("gyr", "T2", 1e-3, 2e-2)
          .in("mag", "M10", 2e-3, 5e-2),
      Family("quant", "quantisation", "y = q round(y/q)")
          .driven_by("none", "rest")
          .mistaken_for("noise", "lattice of values")
          .takes("q_{u}", "q", "{U}", 3)
          .in("acc", "T7", 6e-4, 5e-3)
          .in("gyr", "T7", 7e-5, 1e-3)
          .in("mag", "T7", 0.006, 0.5),
      Family("drift", "random walk of the offset", "db/dt = w, <w w> = q^2")
          .driven_by("none", "minutes")
          .mistaken_for("any slow driver",
                        "no driver survives once the random walk is in the noise model; Allan slope +1/2")
          .takes("q_{u}_per_sqrts", "q", "{U}/sqrt(s)", 3)
          .in("acc", "G14", 1e-5, 1e-3)
          .in("gyr", "G14", 1e-6, 1e-4)
          .in("mag", "G14", 1e-3, 1e-1),
  };
}

}  // namespace

std::vector<Family> families_of_several_sensors() {
  std::vector<Family> all = of_temperature_and_supply();
  for (const auto& part : {of_amplitude_and_vibration(), of_filter_and_converter()})
    all.insert(all.end(), part.begin(), part.end());
  return all;
}

}  // namespace stillpoint::sim
