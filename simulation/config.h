/// What a simulation YAML says (docs/formats.md): the baseline u = H (y - B) with its noise, a list of effects beyond
/// it, and, where the motion is not taken from a recording, motion and surroundings.
#pragma once
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/fields.h"
#include "core/types.h"
#include "core/units.h"

namespace stillpoint::sim {

enum class Sensor { kAcc, kGyr, kMag };
inline constexpr Sensor kSensors[] = {Sensor::kAcc, Sensor::kGyr, Sensor::kMag};

/// "acc", "gyr" or "mag": how the IDs of the sensor's own effects begin.
[[nodiscard]] constexpr const char* prefix(Sensor sensor) noexcept {
  return sensor == Sensor::kAcc ? "acc" : sensor == Sensor::kGyr ? "gyr" : "mag";
}

/// One triad as configured, in the unit of the reading. The noise is added to y, the reading.
struct TriadConfig {
  Vec3 bias = Vec3::Zero();
  Mat3 matrix = Mat3::Identity();
  double noise_sd = 0.0;               ///< standard deviation of one sample, whatever the band below
  Vec3 noise_axes = Vec3::Ones();      ///< factor on noise_sd per axis
  double noise_band_hz = 0.0;          ///< 0: white; else first-order low-passed noise of the same standard deviation
  double bias_instability = 0.0;       ///< B of IEEE Std 952: the Allan deviation has its floor at 0.664 B
  double random_walk_per_sqrts = 0.0;  ///< unit of the reading per sqrt(s)
  double rate_hz = 0.0;                ///< 0: the rate of the recording
};

/// One entry of `effects:`. Parameters keep the names and units of the catalogue, numbers flattened row-major.
struct EffectConfig {
  std::string id;
  std::map<std::string, std::vector<double>> parameters;
  std::vector<int> axes;                              ///< 0, 1, 2; empty: all
  std::vector<Sensor> sensors{};                      ///< of an effect on several sensors; empty: all it acts on
  std::optional<std::pair<double, double>> window_s;  ///< from the start of the recording; none: all the time
};

struct MotionConfig {
  std::string kind = "hand";
  double duration_s = 130.0;
  double min_bout_s = 4.0, max_bout_s = 10.0;
  double min_rest_s = 2.5, max_rest_s = 5.0;
  double rate_radps = 1.5;
  double sway_m = 0.05;
  int poses = 24;
  double move_s = 1.5;
  double speed_mps = 10.0;
  double vibration_hz = 120.0;
  double vibration_mps2 = 3.0;

  template <class P = MotionConfig>
  static constexpr auto fields() {
    return std::tuple{
        field("kind", &P::kind, "which motion; docs/simulation.md lists them"),
        field("duration_s", &P::duration_s, in_range(0.1, 1e6), "length of the recording"),
        field("min_bout_s", &P::min_bout_s, in_range(0.5, 1e5), "shortest bout of motion"),
        field("max_bout_s", &P::max_bout_s, in_range(0.5, 1e5), "longest bout of motion"),
        field("min_rest_s", &P::min_rest_s, in_range(0.0, 1e5), "shortest rest"),
        field("max_rest_s", &P::max_rest_s, in_range(0.0, 1e5), "longest rest"),
        field("rate_radps", &P::rate_radps, in_range(0.0, 50.0), "typical body rate while moving (rms per axis)"),
        field("sway_m", &P::sway_m, in_range(0.0, 10.0), "typical displacement while moving (rms per axis)"),
        field("poses", &P::poses, in_range(1, 10000), "rest poses, spread evenly over the sphere"),
        field("move_s", &P::move_s, in_range(0.1, 100.0), "time from one rest pose to the next"),
        field("speed_mps", &P::speed_mps, in_range(0.0, 300.0), "cruising speed of a vehicle or drone"),
        field("vibration_hz", &P::vibration_hz, in_range(1.0, 5000.0), "rotor or engine frequency"),
        field("vibration_mps2", &P::vibration_mps2, in_range(0.0, 500.0), "amplitude of the vibration"),
    };
  }
};

struct TemperatureConfig {
  std::string kind = "warm_up";  ///< constant, warm_up, chamber, day, activity
  double start_degC = 25.0, rise_K = 8.0, tau_s = 60.0, period_s = 3600.0, noise_K = 0.03;

  template <class P = TemperatureConfig>
  static constexpr auto fields() {
    return std::tuple{
        field("kind", &P::kind, "constant, warm_up, chamber, day or activity (rises while the body moves)"),
        field("start_degC", &P::start_degC, in_range(-80.0, 200.0), "temperature at the start"),
        field("rise_K", &P::rise_K, in_range(-200.0, 200.0), "how far it rises at most"),
        field("tau_s", &P::tau_s, in_range(0.1, 1e6), "time constant of warm_up and activity"),
        field("period_s", &P::period_s, in_range(1.0, 1e7), "one cycle of chamber or day"),
        field("noise_K", &P::noise_K, in_range(0.0, 10.0), "noise of the thermometer, standard deviation"),
    };
  }
};

struct CurrentConfig {
  std::string kind = "off";  ///< off, steps, activity
  double high_A = 2.0, min_hold_s = 2.0, max_hold_s = 10.0, noise_A = 0.02;

  template <class P = CurrentConfig>
  static constexpr auto fields() {
    return std::tuple{
        field("kind", &P::kind, "off, steps (loads switched at random) or activity (drawn while the body moves)"),
        field("high_A", &P::high_A, in_range(-1000.0, 1000.0), "largest current"),
        field("min_hold_s", &P::min_hold_s, in_range(0.1, 1e5), "shortest time between two switchings"),
        field("max_hold_s", &P::max_hold_s, in_range(0.1, 1e5), "longest time between two switchings"),
        field("noise_A", &P::noise_A, in_range(0.0, 100.0), "noise of the current sensor, standard deviation"),
    };
  }
};

struct SupplyConfig {
  double start_V = 3.7, discharge_V_per_s = 5e-4, resistance_ohm = 0.05, noise_V = 0.001;

  template <class P = SupplyConfig>
  static constexpr auto fields() {
    return std::tuple{
        field("start_V", &P::start_V, in_range(0.0, 1000.0), "voltage at the start without load"),
        field("discharge_V_per_s", &P::discharge_V_per_s, in_range(0.0, 1.0), "steady discharge"),
        field("resistance_ohm", &P::resistance_ohm, in_range(0.0, 100.0), "what the current takes off the voltage"),
        field("noise_V", &P::noise_V, in_range(0.0, 10.0), "noise of the voltage sensor, standard deviation"),
    };
  }
};

/// A magnetic dipole that travels through the world at constant speed: a car that passes, a lift, a tool.
struct IronConfig {
  Vec3 moment_Am2 = Vec3::Zero(), start_m = Vec3::Zero(), velocity_mps = Vec3::Zero();

  template <class P = IronConfig>
  static constexpr auto fields() {
    return std::tuple{field("moment_Am2", &P::moment_Am2, "magnetic moment in the world frame"),
                      field("start_m", &P::start_m, "position at time 0 in the world frame"),
                      field("velocity_mps", &P::velocity_mps, "constant velocity in the world frame")};
  }
};

struct EnvironmentConfig {
  TemperatureConfig temperature;
  CurrentConfig current;
  SupplyConfig supply;
  double latitude_rad = 0.85;
  double height_m = 0.0;
  std::vector<IronConfig> iron;

  template <class P = EnvironmentConfig>
  static constexpr auto fields() {
    return std::tuple{
        field("temperature", &P::temperature, "sensor temperature"),
        field("current", &P::current, "current in a conductor near the magnetometer"),
        field("supply", &P::supply, "supply voltage"),
        field("latitude_rad", &P::latitude_rad, in_range(-1.5708, 1.5708), "for gravity and Earth rotation"),
        field("height_m", &P::height_m, in_range(-500.0, 20000.0), "above the ellipsoid, for gravity"),
        field("iron", &P::iron, "moving iron: a list of dipoles"),
    };
  }
};

/// Samples that never arrive, their time stamps with them. Timing faults that keep the rows are effects (sys_...).
struct TimingConfig {
  double lost_fraction = 0.0;

  static constexpr auto fields() {
    return std::tuple{field("lost_fraction", &TimingConfig::lost_fraction, in_range(0.0, 0.9),
                            "share of the samples that is lost together with its time stamp")};
  }
};

/// Reference columns of the simulated recording.
struct ReferenceConfig {
  std::string kind = "exact";  ///< exact, mocap, none
  double orientation_sd_rad = 0.001, position_sd_m = 2e-4, band_hz = 10.0;
  double latency_s = 0.0;  ///< of its time stamps against the sensors': a row holds the pose of so much earlier
  bool stated = false;     ///< the simulation speaks of its errors: a diagnosis then holds the recording's to them

  template <class P = ReferenceConfig>
  static constexpr auto fields() {
    return std::tuple{
        field("kind", &P::kind, "exact, mocap (with the errors below) or none (no reference columns)"),
        field("orientation_sd_rad", &P::orientation_sd_rad, in_range(0.0, 1.0), "mocap: error per axis"),
        field("position_sd_m", &P::position_sd_m, in_range(0.0, 10.0), "mocap: error per axis"),
        field("band_hz", &P::band_hz, in_range(0.01, 1000.0), "mocap: bandwidth of these errors"),
        field("latency_s", &P::latency_s, in_range(-10.0, 10.0), "late against the sensors' time stamps by this"),
    };
  }
};

struct SimulationConfig {
  double rate_hz = 100.0;
  double gravity_mps2 = kStandardGravity_mps2;
  Vec3 field_world_uT{0.0, 20.0, -43.0};  ///< ENU
  std::optional<TriadConfig> accelerometer, gyroscope, magnetometer;
  std::vector<EffectConfig> effects;
  std::optional<MotionConfig> motion;  ///< none: the motion comes from a recording
  EnvironmentConfig environment;
  TimingConfig timing;
  ReferenceConfig reference;
};

/// The values `motion: {kind: ...}` may take.
[[nodiscard]] const std::vector<std::string>& motion_kind_names();

/// Normal gravity on and above the WGS 84 ellipsoid, m/s^2: Somigliana's formula with the second-order height term
/// (NIMA TR8350.2, eqs. 4-1 and 4-3).
[[nodiscard]] double normal_gravity_mps2(double latitude_rad, double height_m);

}  // namespace stillpoint::sim
