#include "diagnosis/reference/nameless.h"

#include <fmt/format.h>

#include <cmath>
#include <numeric>
#include <utility>

#include "diagnosis/certainty.h"
#include "diagnosis/reference/left_at_rest.h"
#include "simulation/effect_catalogue.h"

namespace stillpoint::diag {

std::string missing_drivers(const Signals& s, Sensor k) {
  std::vector<std::string> missing;
  if (!s.temperature_K.size()) missing.emplace_back("temp_degC");
  if (!s.voltage_V.size() && k != kMag) missing.emplace_back("supply_V");
  if (!s.current_A.size() && k == kMag) missing.emplace_back("current_A");
  if (missing.empty()) return {};
  return fmt::format("{}", fmt::join(missing, " and "));
}

Finding remainder_finding(const SensorSearch& search) {
  Finding out;
  out.effect = "unknown:u(t)";
  out.driver = "something that no recorded quantity drives";
  out.equation = "delta = u, of no known form";
  for (const char* axis : kAxisName) out.channels.push_back(std::string(kSensorName[search.sensor]) + "_" + axis);
  out.held_out.unit = kSensorUnit[search.sensor];
  out.decided_by = "record slow motion through every attitude, and every quantity that could drive it";
  return out;
}

Finding switching_finding(Finding first, const Signals& s, const SensorSearch& search) {
  Finding out = std::move(first);
  out.effect = "unknown:switched(t)";
  std::vector<std::size_t> all(search.found.size());
  std::iota(all.begin(), all.end(), 0);
  out.held_out = held_out_by_regime(search, all);
  out.equivalent.clear();
  out.parameters.clear();
  out.interval_s = {0.0, s.duration_s()};
  out.regime = "comes and goes";
  out.equation = "an offset fixed in the body that switches";
  out.driver = "something that switches and is not in the recording";
  const std::string missing = missing_drivers(s, search.sensor);
  out.decided_by = missing.empty() ? "record what is switched near the sensor" : "record " + missing;
  return out;
}

std::string drift_id(Sensor sensor) { return std::string(kSensorName[sensor]) + "_drift"; }

Finding drift_finding(const Signals& s, const SensorSearch& search, const Finished& finished) {
  Finding out;
  const std::string sensor = kSensorName[search.sensor];
  out.effect = drift_id(search.sensor);
  out.equation = "db/dt = w, <w w> = q^2";
  out.driver = "time: a slow drift that no recorded quantity drives";
  out.regime = "all the time";
  out.interval_s = {0.0, s.duration_s()};
  for (std::size_t a = 0; a < 3; ++a) {
    const double q = finished.fit.walk_q[a];
    out.parameters.push_back({std::string("q_") + kAxisName[a],
                              q,
                              {0.5 * q, 2.0 * q},
                              std::string(kSensorUnit[search.sensor]) + "/sqrt(s)"});
    if (q > 0) out.channels.push_back(sensor + "_" + kAxisName[a]);
  }
  out.held_out.gain_nats = finished.walk_gain_nats;
  out.held_out.unit = kSensorUnit[search.sensor];
  out.p_value = chance_of(finished.walk_gain_nats);
  // Over minutes a flicker and a walk look alike; the Allan deviation of hours tells them apart.
  if (search.sensor == kGyr) out.equivalent.emplace_back("gyr_instability");
  const std::string missing = missing_drivers(s, search.sensor);
  out.decided_by = missing.empty() ? "a longer recording with a second ramp of each driver"
                                   : "record " + missing + ": it could drive this";
  return out;
}

sim::EffectConfig drift_effect(Sensor sensor, const Finished& finished) {
  sim::EffectConfig e;
  e.id = drift_id(sensor);
  const auto& q = finished.fit.walk_q;
  e.parameters[sim::find_effect(e.id)->parameters.front().key] = {q.begin(), q.end()};
  return e;
}

void without_noise_of(Sensor k, Diagnosis& out) {
  std::erase_if(out.noise, [k](const NoiseFault& n) { return n.channel.starts_with(kSensorName[k]); });
}

void tell_swings(const Signals& s, const SensorSearch& search, const Finished& finished, Diagnosis& out) {
  auto swings = swings_at_rest(s, search, finished);
  if (!swings) return;
  without_noise_of(search.sensor, out);
  out.unaccounted.push_back(std::move(*swings));
  out.notices.push_back(fmt::format(
      "{}: the body vibrates where the reference cannot see it, or the sensor makes a line of varying frequency. "
      "Switch off what turns nearby, or record its speed, and the sensor at a higher rate",
      kSensorName[search.sensor]));
}

void tell_left_in_motion(const Signals& s, const SensorSearch& search, const Finished& finished, Diagnosis& out) {
  constexpr double kFar = 5.0, kLeastOfEach = 200.0;
  const Sensor k = search.sensor;
  if (!s.exact_reference || s.unresolved[k] || !(s.noise_sd[k] > 0)) return;
  double moving = 0.0, square_moving = 0.0, resting = 0.0, square_resting = 0.0;
  for (Eigen::Index i = 0; i < search.target.layout.n; ++i) {
    const double rows = search.target.layout.counts[i],
                 square = rows * finished.fit.leftover.row(i).squaredNorm() / 3.0;
    const bool rests = s.rest[static_cast<std::size_t>(i)];
    (rests ? resting : moving) += rows, (rests ? square_resting : square_moving) += square;
  }
  if (moving < kLeastOfEach) return;
  const double lattice = s.lattice_step[k] / std::sqrt(12.0);
  const double noise =
      std::max(std::hypot(s.noise_sd[k], lattice), resting < kLeastOfEach ? 0.0 : std::sqrt(square_resting / resting));
  const double times = std::sqrt(square_moving / moving) / noise;
  if (times < kFar) return;
  out.unaccounted.push_back(fmt::format(
      "{} in motion is off by {:.2g} times what it is at rest, beside all that was found", kSensorName[k], times));
}

}  // namespace stillpoint::diag
