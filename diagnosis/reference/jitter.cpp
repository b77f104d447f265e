#include <algorithm>
#include <cmath>

#include "diagnosis/certainty.h"
#include "diagnosis/finding_effect.h"
#include "diagnosis/reference/apparatus.h"
#include "diagnosis/reference/evidence.h"
#include "diagnosis/reference/jitter.h"
#include "diagnosis/reference/row_lateness.h"

namespace stillpoint::diag {
namespace {

constexpr double kLeastNats = 30.0;       // more than the least a law needs: its noise model is the simpler one
constexpr double kWitness = 3.0;          // nats with which a sensor says so itself
constexpr double kContradiction = -5.0;   // nats of one sensor that speak against the others
constexpr double kLeastOfExpected = 0.3;  // of the gain that a common clock would give: less is one sensor's own noise
constexpr double kTellsMemory_nats = 10.0;  // of less the correlation is chance
constexpr double kWhite = 0.3;              // correlation of neighbours: a delay or a lost sample lasts
constexpr double kSlowest_s = 1e-6, kFastest_s = 2e-2;
constexpr int kGrid = 80;
constexpr std::size_t kLeastInMotion = 200;  // rows of a sensor, to say anything of its clock
constexpr double kFarOverNoise = 1.5;  // beside laws: what a shift in time is wrong by is along the derivative too
constexpr int kFits = 4;               // of laws and times, by turns: each leaves a third of a law's error or less

double gain_of(const TimedRows& rows, double sd_s) {
  double sum = 0.0;
  for (std::size_t i = 0; i < rows.at.size(); ++i) {
    const double v = rows.noise[i], w = v + std::pow(sd_s * rows.slope[i], 2), y2 = rows.along[i] * rows.along[i];
    sum -= 0.5 * (std::log(w / v) + y2 / w - y2 / v);
  }
  return sum;
}

/// What a jitter of this size would gain in these rows.
double expected_gain(const TimedRows& rows, double sd_s) {
  double sum = 0.0;
  for (std::size_t i = 0; i < rows.at.size(); ++i) {
    const double ratio = 1.0 + std::pow(sd_s * rows.slope[i], 2) / rows.noise[i];
    sum += 0.5 * (ratio - 1.0 - std::log(ratio));
  }
  return sum;
}

/// Covariance of neighbours over the variance that jitter adds.
double memory_of(const TimedRows& rows) {
  double pairs = 0.0, excess = 0.0;
  for (std::size_t i = 0; i < rows.at.size(); ++i) {
    const double weight = 1.0 / rows.noise[i], y = rows.along[i];
    excess += weight * (y * y - rows.noise[i]);
    if (i > 0 && rows.at[i] == rows.at[i - 1] + 1) pairs += weight * y * rows.along[i - 1];
  }
  return excess > 0 ? pairs / excess : 1.0;
}

struct Jitter {
  double sd_s = 0.0, half_s = 0.0, gain_nats = 0.0;
};

double total(const std::vector<TimedRows>& sensors, double sd_s) {
  double sum = 0.0;
  for (const TimedRows& r : sensors) sum += gain_of(r, sd_s);
  return sum;
}

Jitter most_likely(const std::vector<TimedRows>& sensors) {
  Jitter best;
  const double step = std::log(kFastest_s / kSlowest_s) / kGrid;
  for (int i = 0; i <= kGrid; ++i)
    for (const double sd = kSlowest_s * std::exp(step * i); const double gain : {total(sensors, sd)})
      if (gain > best.gain_nats) best.sd_s = sd, best.gain_nats = gain;
  if (best.sd_s == 0.0) return best;
  const auto at = [&](double x) { return total(sensors, best.sd_s * std::exp(x)); };
  const double low = at(-step), high = at(step), bend = low - 2.0 * best.gain_nats + high;
  if (bend >= 0.0) return best;
  const double shift = std::clamp(0.5 * step * (low - high) / bend, -step, step);
  best.sd_s *= std::exp(shift);
  best.half_s = 1.96 * best.sd_s * step / std::sqrt(-bend);
  best.gain_nats = total(sensors, best.sd_s);
  return best;
}

struct MeanSquares {
  double along = 0.0, noise = 0.0;
};

MeanSquares mean_squares(const TimedRows& r) {
  MeanSquares sum;
  for (std::size_t i = 0; i < r.at.size(); ++i) sum.along += r.along[i] * r.along[i], sum.noise += r.noise[i];
  const double n = std::max<double>(static_cast<double>(r.at.size()), 1.0);
  return {sum.along / n, sum.noise / n};
}

bool stands_out(const TimedRows& r) {
  const MeanSquares m = mean_squares(r);
  return m.along > kFarOverNoise * kFarOverNoise * m.noise;
}

Finding finding_of(const Signals& s, const std::vector<TimedRows>& sensors, const Jitter& jitter) {
  Finding f;
  f.effect = "sys_jitter";
  f.equation = "u(t) = true(t + d), d white";
  f.driver = "derivatives of the true vectors";
  f.regime = "in motion, at random from row to row; the faster, the more";
  f.interval_s = {0.0, s.duration_s()};
  double largest = 0.0;
  for (const TimedRows& r : sensors) {
    const double gain = gain_of(r, jitter.sd_s);
    if (gain > 3.0)
      for (const char* axis : kAxisName) f.channels.push_back(std::string(kSensorName[r.sensor]) + "_" + axis);
    if (gain <= largest) continue;
    largest = gain;
    const MeanSquares m = mean_squares(r);
    f.held_out.rms_before = std::sqrt(m.along);
    f.held_out.rms_after = f.held_out.noise_floor = std::sqrt(m.noise);
    f.held_out.unit = kSensorUnit[r.sensor];
  }
  f.parameters = {{"sd", jitter.sd_s, {jitter.sd_s - jitter.half_s, jitter.sd_s + jitter.half_s}, "s"}};
  f.held_out.gain_nats = jitter.gain_nats;
  f.p_value = chi_square_tail(2.0 * jitter.gain_nats, 1.0);
  f.confidence = confidence_of(jitter.gain_nats - kLeastNats);
  f.runner_up_effect = "noise that grows with motion";
  f.runner_up_why_rejected = "it would lie across the derivative as well as along it";
  f.decided_by = "time stamps taken by the sensor itself (data ready) beside those of the host";
  return f;
}

/// Takes what the rows are late, by these sensors, out of all residuals, in the place of what was taken out before.
void set_right(Signals& s, const std::vector<TimedRows>& sensors, const std::array<Seen, kSensors>& seen) {
  const Series late_s = lateness_of(s, sensors, seen, s.jitter_sd_s);
  for (const Sensor k : {kAcc, kGyr, kMag}) {
    if (seen[k].vector.rows() == 0) continue;
    if (s.by_times[k].rows() > 0) s.residual[k] += s.by_times[k];
    s.by_times[k] = effect_of_lateness(s, seen[k].vector, late_s);
    s.residual[k] -= s.by_times[k];
  }
}

/// Rows in motion of each sensor; `sd_s`: of their times.
std::vector<TimedRows> timed_rows(const Signals& s, const std::array<Seen, kSensors>& seen, double sd_s) {
  std::vector<TimedRows> sensors;
  for (const Sensor k : {kAcc, kGyr, kMag})
    if (seen[k].vector.rows() > 0)
      if (TimedRows r = rows_of(s, k, seen[k], sd_s); r.at.size() > kLeastInMotion) sensors.push_back(std::move(r));
  return sensors;
}

std::array<Seen, kSensors> seen_as_predicted(const Signals& s) {
  std::array<Seen, kSensors> out;
  for (const Sensor k : {kAcc, kGyr, kMag})
    if (s.compared(k)) out[k] = {s.vector[k], s.residual[k]};
  return out;
}

bool holds_a_law(const EngineResult& found) {
  return !found.system.empty() || std::any_of(found.sensor.begin(), found.sensor.end(),
                                              [](const auto& search) { return search && !search->found.empty(); });
}

/// With the laws that were found, of residuals that have changed since, and without what the rows' times do.
std::array<Seen, kSensors> seen_with_laws(const Signals& s, const EngineResult& found,
                                          const std::array<Series3, kSensors>& searched) {
  std::array<Seen, kSensors> out;
  for (const Sensor k : {kAcc, kGyr, kMag}) {
    if (!found.sensor[k]) continue;
    Target t = found.sensor[k]->target;
    t.residual += s.residual[k] - searched[k];
    const Series3 left = fit_profile(t, found.sensor[k]->explained()).leftover;
    out[k] = {s.vector[k], left};
    // A clock that is wrong by a part of a second shows another moment's derivative.
    if (!vector_is_reading(s, k)) out[k].vector += s.residual[k] - left;
    if (s.by_times[k].rows() > 0) out[k].deviation += s.by_times[k];
  }
  return out;
}

/// `sensors`: their rows without a jitter.
bool find_jitter_in(const std::array<Seen, kSensors>& seen, std::vector<TimedRows> sensors, Signals& s,
                    const sim::SimulationConfig& given, Answer& answer) {
  Jitter jitter = most_likely(sensors);
  if (jitter.gain_nats < kLeastNats) return false;
  for (TimedRows& r : sensors) r = rows_of(s, r.sensor, seen[r.sensor], jitter.sd_s);
  jitter = most_likely(sensors);
  // The field of a place may jump by itself: the magnetometer alone is no witness of the clock.
  double witnessed = 0.0;
  int inertial = 0, witnesses = 0;
  for (const TimedRows& r : sensors) {
    if (r.sensor == kMag) continue;
    const double gain = gain_of(r, jitter.sd_s);
    witnessed += gain, ++inertial, witnesses += gain > kWitness;
  }
  // One sensor's noise may grow with its motion by itself.
  if (witnessed < kLeastNats || witnesses < inertial) return false;
  for (const TimedRows& r : sensors) {
    const double gain = gain_of(r, jitter.sd_s);
    // One clock for all; a magnetometer often has one of its own.
    const double due = r.sensor == kMag ? 0.0 : kLeastOfExpected * expected_gain(r, jitter.sd_s);
    if (gain < kContradiction + due || (gain > kTellsMemory_nats && std::abs(memory_of(r)) > kWhite)) return false;
  }
  if (!contains(given.effects, "sys_jitter")) {
    answer.diagnosis.findings.push_back(finding_of(s, sensors, jitter));
    answer.effects.push_back({.id = "sys_jitter", .parameters = {{"sd_s", {jitter.sd_s}}}, .axes = {}, .window_s = {}});
  }
  s.jitter_sd_s = jitter.sd_s;
  set_right(s, sensors, seen);
  return true;
}

}  // namespace

void find_jitter(Signals& s, const sim::SimulationConfig& given, Answer& answer) {
  const auto seen = seen_as_predicted(s);
  find_jitter_in(seen, timed_rows(s, seen, 0.0), s, given, answer);
}

bool find_jitter_beside(const EngineResult& found, Signals& s, const sim::SimulationConfig& given, Answer& answer) {
  const bool resolved = !s.unresolved[kAcc] && !s.unresolved[kGyr];
  if (s.jitter_sd_s > 0.0 || !resolved || !holds_a_law(found)) return false;
  const auto seen = seen_with_laws(s, found, s.residual);
  std::vector<TimedRows> sensors = timed_rows(s, seen, 0.0);
  return std::any_of(sensors.begin(), sensors.end(), stands_out) &&
         find_jitter_in(seen, std::move(sensors), s, given, answer);
}

bool time_rows_again(Signals& s, const EngineResult& found) {
  const bool timed = std::any_of(s.by_times.begin(), s.by_times.end(), [](const Series3& x) { return x.rows() > 0; });
  if (!timed || !holds_a_law(found)) return false;
  const std::array<Series3, kSensors> searched = s.residual;
  for (int fit = 0; fit < kFits; ++fit) {
    const auto seen = seen_with_laws(s, found, searched);
    set_right(s, timed_rows(s, seen, s.jitter_sd_s), seen);
  }
  return true;
}

}  // namespace stillpoint::diag
