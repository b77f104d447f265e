#include "simulation/environment.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/units.h"
#include "simulation/random.h"

namespace stillpoint::sim {
namespace {

constexpr double kActivityStep_s = 0.25;

/// tau dx/dt = (moving ? 1 : 0) - x, on a grid.
TimeSeries heating_by_activity(const Motion& motion, double tau_s) {
  TimeSeries out;
  const double keep = std::exp(-kActivityStep_s / tau_s);
  double x = 0.0;
  for (double t = 0.0; t <= motion.duration_s() + kActivityStep_s; t += kActivityStep_s) {
    out.t_s.push_back(t);
    out.value.push_back(x);
    x = keep * x + (motion.at(t + 0.5 * kActivityStep_s).moving ? 1.0 - keep : 0.0);
  }
  return out;
}

TimeSeries switched_load(const CurrentConfig& c, const Motion& motion, std::uint64_t seed) {
  TimeSeries out;
  out.steps = true;
  Stream random(seed, "environment current");
  const auto set = [&](double t_s, double value_A) {
    out.t_s.push_back(t_s);
    out.value.push_back(value_A);
  };
  set(0.0, 0.0);
  if (c.kind == "steps")
    for (double t = 0.0; t < motion.duration_s();
         t += random.uniform(c.min_hold_s, std::max(c.min_hold_s, c.max_hold_s)))
      set(t, random.uniform() < 0.4 ? 0.0 : c.high_A * random.uniform(0.2, 1.0));
  bool moved = false;
  if (c.kind == "activity")
    for (double t = 0.0; t < motion.duration_s(); t += kActivityStep_s)
      if (const bool moves = motion.at(t).moving; moves != moved) {
        set(t, moves ? c.high_A * random.uniform(0.3, 1.0) : 0.0);
        moved = moves;
      }
  return out;
}

}  // namespace

double TimeSeries::at(double time_s) const noexcept {
  const auto after = std::upper_bound(t_s.begin(), t_s.end(), time_s);
  if (after == t_s.begin()) return value.front();
  const auto i = static_cast<std::size_t>(after - t_s.begin());
  if (steps || after == t_s.end()) return value[i - 1];
  const double share = (time_s - t_s[i - 1]) / (t_s[i] - t_s[i - 1]);
  return value[i - 1] + share * (value[i] - value[i - 1]);
}

Environment::Environment(const EnvironmentConfig& config, const Motion& motion, RecordedEnvironment recorded,
                         std::uint64_t seed)
    : config_(config), recorded_(std::move(recorded)) {
  const std::string& kind = config_.temperature.kind;
  course_ = kind == "constant"  ? Course::kConstant
            : kind == "warm_up" ? Course::kWarmUp
            : kind == "chamber" ? Course::kChamber
            : kind == "day"     ? Course::kDay
                                : Course::kActivity;
  if (config_.temperature.kind == "activity") heating_ = heating_by_activity(motion, config_.temperature.tau_s);
  if (config_.current.kind != "off") load_A_ = switched_load(config_.current, motion, seed);
  earth_rate_radps_ = kEarthRate_radps * Vec3(0.0, std::cos(config_.latitude_rad), std::sin(config_.latitude_rad));
}

double Environment::temp_degC(double t_s) const noexcept {
  if (!recorded_.temp_degC.t_s.empty()) return recorded_.temp_degC.at(t_s);
  const auto& c = config_.temperature;
  const double turn = 2.0 * std::numbers::pi * t_s / c.period_s;
  switch (course_) {
    case Course::kConstant:
      return c.start_degC;
    case Course::kWarmUp:
      return c.start_degC + c.rise_K * (1.0 - std::exp(-std::max(0.0, t_s) / c.tau_s));
    case Course::kChamber:
      return c.start_degC + 0.5 * c.rise_K * (1.0 - std::cos(turn));
    case Course::kDay:
      return c.start_degC + c.rise_K * std::sin(turn);
    case Course::kActivity:
      break;
  }
  return c.start_degC + c.rise_K * heating_.at(t_s);
}

double Environment::current_A(double t_s) const noexcept {
  if (!recorded_.current_A.t_s.empty()) return recorded_.current_A.at(t_s);
  return load_A_.t_s.empty() ? 0.0 : load_A_.at(t_s);
}

double Environment::supply_V(double t_s) const noexcept {
  if (!recorded_.supply_V.t_s.empty()) return recorded_.supply_V.at(t_s);
  const auto& c = config_.supply;
  return c.start_V - c.discharge_V_per_s * t_s - c.resistance_ohm * current_A(t_s);
}

/// Dipole: B = mu0 / (4 pi) (3 (m.d) d - m) / r^3 with d the unit vector from the dipole; mu0 / (4 pi) is 0.1 uT m^3 /
/// (A m^2). Closer than 5 cm the point dipole is no model; the distance is held there.
Vec3 Environment::iron_field_uT(const Vec3& position_m, double t_s) const noexcept {
  Vec3 sum = Vec3::Zero();
  for (const auto& iron : config_.iron) {
    const Vec3 away = position_m - (iron.start_m + t_s * iron.velocity_mps);
    const double distance = std::max(away.norm(), 0.05);
    const Vec3 d = away / distance;
    sum += 0.1 * (3.0 * iron.moment_Am2.dot(d) * d - iron.moment_Am2) / (distance * distance * distance);
  }
  return sum;
}

double Environment::user(std::string_view name, double t_s) const noexcept {
  const auto found = recorded_.user.find(name);
  return found == recorded_.user.end() || found->second.t_s.empty() ? 0.0 : found->second.at(t_s);
}

}  // namespace stillpoint::sim
