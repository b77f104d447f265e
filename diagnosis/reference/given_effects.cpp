#include "diagnosis/reference/given_effects.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/units.h"
#include "diagnosis/discovery/law_delta.h"
#include "diagnosis/reference/apparatus.h"
#include "diagnosis/reference/clock_of_rows.h"
#include "diagnosis/reference/columns.h"
#include "diagnosis/reference/lines.h"
#include "diagnosis/reference/timing_in_window.h"
#include "simulation/effect_catalogue.h"

namespace stillpoint::diag {
namespace {

constexpr double kPpm = 1e-6;
constexpr double kNoLimit_uT = 1e5;
constexpr std::array<const char*, kSensors> kLevelKey{"L_mps2", "L_radps", "L_uT"};
constexpr std::array<const char*, kSensors> kLineKey{"b_mps2", "b_radps", "b_uT"};

std::vector<double> list(const Eigen::VectorXd& v, Eigen::Index first, Eigen::Index count) {
  return {v.data() + first, v.data() + first + count};
}

double scalar(const sim::EffectConfig& e, const std::string& key, double fallback) {
  const auto it = e.parameters.find(key);
  return it == e.parameters.end() || it->second.empty() ? fallback : it->second.front();
}

Vec3 vec3_of(const sim::EffectConfig& e, const std::string& key) {
  const auto it = e.parameters.find(key);
  if (it == e.parameters.end() || it->second.empty()) return Vec3::Zero();
  const std::vector<double>& v = it->second;
  return v.size() == 3 ? Vec3(v[0], v[1], v[2]) : Vec3::Constant(v[0]);
}

/// The window in which an entry acts, in samples.
Window window_of(const sim::EffectConfig& e, const Signals& s) {
  Window w;
  const double t0 = scalar(e, "t0_s", 0.0);
  w.begin = row_at(s, std::max(t0, e.window_s ? e.window_s->first : 0.0));
  w.end = e.window_s ? std::max(w.begin, row_at(s, e.window_s->second)) : s.n;
  w.local = w.begin > 0 || w.end < s.n;
  return w;
}

void subtract_in_window(Signals& s, Sensor k, const sim::EffectConfig& e, const Series3& delta) {
  const Window w = window_of(e, s);
  s.residual[k].middleRows(w.begin, w.end - w.begin) -= delta.middleRows(w.begin, w.end - w.begin);
}

/// The values of an entry in the order of the law's coefficients; empty when they do not fit it.
std::vector<double> values_for(const Law& law, const sim::EffectConfig& e) {
  const sim::EffectInfo* info = sim::find_effect(e.id);
  std::vector<double> first, second;
  for (const auto& p : info->parameters) {
    const auto it = e.parameters.find(p.key);
    if (p.count == 1 && law.coefficients.size() > 1) continue;
    std::vector<double> v =
        it != e.parameters.end() ? it->second : std::vector<double>(static_cast<std::size_t>(p.count), p.fallback);
    if (v.size() == 1 && p.count == 3) v.resize(3, v[0]);
    (p.required ? first : second).insert((p.required ? first : second).end(), v.begin(), v.end());
  }
  if (law.coefficients.size() == first.size()) return first;
  second.insert(second.end(), first.begin(), first.end());  // temp_quad: k1 stands before k2
  return law.coefficients.size() == second.size() ? second : std::vector<double>{};
}

bool acts_on(const sim::EffectConfig& e, int axis) {
  return e.axes.empty() || std::find(e.axes.begin(), e.axes.end(), axis) != e.axes.end();
}

/// What a bias tracker on board lets through; the estimate itself follows every axis.
Series3 let_through(const Signals& s, const sim::EffectConfig* tracker, Series3 delta) {
  if (tracker == nullptr) return delta;
  for (int axis = 0; axis < 3; ++axis)
    if (acts_on(*tracker, axis))
      delta.col(axis) = after_tracker(delta.col(axis), s.rest, s.dt_s, scalar(*tracker, "tau_s", 20.0));
  return delta;
}

bool subtract_linear(Signals& s, Sensor k, const sim::EffectConfig& e, const sim::EffectConfig* tracker) {
  const bool hidden = scalar(e, "hidden", 0.0) == 1.0;
  for (const Law& law : make_laws(s, k)) {
    if (law.id != e.id || law.kind != Kind::kNamed) continue;
    std::vector<double> values = hidden ? std::vector<double>{1.0} : values_for(law, e);
    if (e.id == "mag_sat") {
      const auto bend = e.parameters.find("k3_per_uT_2");
      values = bend == e.parameters.end() ? std::vector<double>{} : bend->second;
    }
    if (values.size() != law.coefficients.size()) continue;
    if (e.id.ends_with("temp_quad") && values.size() == 3 && e.parameters.size() > 1) continue;
    const double shape = hidden ? scalar(e, kLevelKey[k], 0.0) : scalar(e, "tau_s", law.shapes.front());
    const Columns columns = in_window(law.columns(shape), window_of(e, s));
    Series3 delta = contribution_of(
        columns, Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size())), s.n);
    for (int axis = 0; axis < 3; ++axis)
      if (!acts_on(e, axis)) delta.col(axis).setZero();
    if (k == kGyr) s.given_rate = s.given_rate.rows() == 0 ? delta : Series3(s.given_rate + delta);
    s.residual[k] -= let_through(s, k == kGyr ? tracker : nullptr, std::move(delta));
    return true;
  }
  return false;
}

/// Lines and flips: functions of time alone.
bool subtract_line(Signals& s, Sensor k, const sim::EffectConfig& e) {
  const bool coning = e.id == "gyr_coning", flip = e.id == "mag_flip";
  if (!flip && !is_line(e.id)) return false;
  const double turn = 2.0 * std::numbers::pi * scalar(e, "f_hz", 0.0);
  const std::vector<double>& size = e.parameters.at(coning ? "a_rad" : kLineKey[k]);
  Series3 delta(s.n, 3);
  for (Eigen::Index i = 0; i < s.n; ++i)
    for (int axis = 0; axis < 3; ++axis) {
      const double a = size[size.size() == 1 ? 0 : static_cast<std::size_t>(axis)], t = s.t_s[i];
      const double own = coning ? e.parameters.at("p_rad")[static_cast<std::size_t>(axis)] : 0.0;
      const double value = flip     ? (i % 2 == 0 ? a : -a)
                           : coning ? a * turn * std::cos(turn * t + own)
                                    : a * std::sin(turn * t + scalar(e, "phase_rad", 0.0));
      delta(i, axis) = acts_on(e, axis) ? value : 0.0;
    }
  subtract_in_window(s, k, e, delta);
  return true;
}

bool subtract_earth(Signals& s, const sim::EffectConfig& e, double latitude_rad) {
  const Vec3 here = kEarthRate_radps * Vec3(0.0, std::cos(latitude_rad), std::sin(latitude_rad));
  const Vec3 w = e.parameters.contains("w_radps") ? vec3_of(e, "w_radps") : Vec3(scalar(e, "scale", 1.0) * here);
  for (int a = 0; a < 3; ++a) s.residual[kGyr] -= w[a] * s.world_axis[static_cast<std::size_t>(a)];
  return true;
}

void subtract_gradient(Signals& s, const sim::EffectConfig& e) {
  const Mat3 G = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(e.parameters.at("G_uT_per_m").data());
  const Vec3 in_the_middle = vec3_of(e, "b_world_uT") + G * s.mean_position_m;
  const Series3 delta = in_body(s, (s.position_m * G.transpose()).rowwise() + in_the_middle.transpose());
  subtract_in_window(s, kMag, e, delta);
}

std::optional<Eigen::VectorXd> timing_values(const sim::EffectConfig& e, const Signals& s) {
  if (e.id == "sys_gap") return Eigen::VectorXd::Constant(1, -scalar(e, "n", 0.0) * s.dt_s);
  if (e.id == "sys_skew" && e.parameters.contains("k_ppm_per_K")) {
    if (s.temperature_K.size() == 0) return std::nullopt;
    return Eigen::Vector2d(kPpm * scalar(e, "eps_ppm", 0.0), kPpm * scalar(e, "k_ppm_per_K", 0.0));
  }
  if (e.id == "sys_skew") return Eigen::VectorXd::Constant(1, kPpm * scalar(e, "eps_ppm", 0.0));
  if (e.id.find("resonance") != std::string::npos)
    return Eigen::Vector2d(scalar(e, "f_hz", 100.0), scalar(e, "zeta", 0.1));
  if (e.parameters.count("tau_s") != 0) return Eigen::VectorXd::Constant(1, scalar(e, "tau_s", 0.0));
  return std::nullopt;
}

bool subtract_timing(Signals& s, Sensor k, const sim::EffectConfig& e) {
  const auto values = timing_values(e, s);
  if (!values || e.id.find("_temp_") != std::string::npos) return false;
  const std::string id = e.id == "sys_offset" ? std::string(kSensorName[k]) + "_delay" : e.id;
  const Window w = window_of(e, s);
  for (const TimingLaw& law : make_timing_laws(s, k, std::max<Eigen::Index>(w.begin, 1))) {
    if (law.id != id) continue;
    s.residual[k] -= in_window(law, w).delta(*values);
    return true;
  }
  return false;
}

/// Amplitude and phase of each axis from the coefficients of sine and cosine.
void set_coning(const Found& found, const Eigen::VectorXd& values, sim::EffectConfig& e) {
  const double turn = 2.0 * std::numbers::pi * found.shape;
  for (Eigen::Index i = 0; i < 3; ++i) {
    e.parameters["a_rad"].push_back(std::hypot(values[i], values[i + 3]) / turn);
    e.parameters["p_rad"].push_back(std::atan2(-values[i], values[i + 3]));
  }
  e.parameters["f_hz"] = {found.shape};
}

/// The catalogue's gradient is about the zero of the positions.
void set_gradient(const Signals& s, const Eigen::VectorXd& values, sim::EffectConfig& e) {
  const Mat3 G = gradient_of(values.head(5));
  e.parameters["G_uT_per_m"] = list(G.reshaped(), 0, 9);
  e.parameters["b_world_uT"] = list(values.tail(3) - G * s.mean_position_m, 0, 3);
}

/// The laws whose coefficients are not the catalogue's parameters; false for the others.
bool set_by_rule(const Found& found, const Eigen::VectorXd& values, double dt_s, double begin_s, sim::EffectConfig& e) {
  if (found.id == "sys_gap")
    e.parameters = {{"n", {std::round(-values[0] / dt_s)}}, {"t0_s", {begin_s}}};
  else if (found.id == "sys_skew") {
    e.parameters = {{"eps_ppm", {values[0] / kPpm}}};
    if (values.size() == 2) e.parameters["k_ppm_per_K"] = {values[1] / kPpm};
  } else if (found.id == "gyr_earth")
    e.parameters = {{"w_radps", list(values, 0, 3)}};
  else if (found.id == "mag_sat")  // the bend alone: no reading has met a limit
    e.parameters = {{"L_uT", std::vector<double>(3, kNoLimit_uT)}, {"k3_per_uT_2", list(values, 0, 3)}};
  else if (found.id == "gyr_coning")
    set_coning(found, values, e);
  else
    return false;
  return true;
}

/// The others: times and shapes by their names, the coefficients in the catalogue's order. False where a required
/// parameter is left without a value.
bool set_in_order(const Found& found, const Eigen::VectorXd& values, double begin_s, const sim::EffectInfo& info,
                  sim::EffectConfig& e) {
  Eigen::Index next = 0;
  if (values.size() == 6) {  // temp_quad with its linear part
    for (const auto& p : info.parameters) e.parameters[p.key] = list(values, p.required ? 3 : 0, 3);
    next = 6;
  }
  for (const auto& p : info.parameters) {
    if (const auto fixed = found.fixed.find(p.key); fixed != found.fixed.end())
      e.parameters[p.key] = {fixed->second};
    else if (p.key == "t0_s")
      e.parameters[p.key] = {begin_s};
    else if (p.symbol == "L")
      e.parameters[p.key] = std::vector<double>(3, found.shape);
    else if (p.key == found.shape_name + "_s" && !found.shape_name.empty())
      e.parameters[p.key] = {found.shape};
    else if (next + p.count <= values.size())
      e.parameters[p.key] = list(values, next, p.count), next += p.count;
    else if (p.required && e.parameters.count(p.key) == 0)
      return false;
  }
  return true;
}

}  // namespace

std::optional<sim::EffectConfig> to_effect(const Found& found, const Eigen::VectorXd& values, const Signals& s) {
  const sim::EffectInfo* info = sim::find_effect(found.id);
  if (info == nullptr) return std::nullopt;
  sim::EffectConfig e;
  e.id = found.id;
  const double begin_s = begin_of_row_s(s, found.window.begin);
  if (found.id == "mag_gradient")
    set_gradient(s, values, e);
  else if (set_by_rule(found, values, s.dt_s, begin_s, e))
    return e;
  else if (!set_in_order(found, values, begin_s, *info, e))
    return std::nullopt;
  // The catalogue's law is about one supply; about another it leaves an offset that no entry holds.
  if (found.window.local && found.id.ends_with("_volt") && found.shape != sim::kReferenceSupply_V) return std::nullopt;
  if (found.window.local) e.window_s = {begin_s, begin_of_row_s(s, found.window.end)};
  return e;
}

std::vector<std::string> subtract_effects(Signals& s, const std::vector<sim::EffectConfig>& effects) {
  std::vector<std::string> unknown;
  const auto at = std::find_if(effects.begin(), effects.end(), [](const auto& e) { return e.id == "sys_tracker"; });
  const sim::EffectConfig* tracker = at == effects.end() ? nullptr : &*at;
  for (const sim::EffectConfig& e : effects) {
    bool done = e.id == "sys_tracker";
    if (e.id == "ref_frame") turn_into_sensor_frame(s, vec3_of(e, "phi_rad")), done = true;
    for (const Sensor k : {kAcc, kGyr, kMag}) {
      if (!s.compared(k)) continue;
      if (const auto delta = law_delta(s, k, e)) s.residual[k] -= *delta, done = true;
      const bool mine = e.id.rfind(std::string(kSensorName[k]) + "_", 0) == 0, common = e.id.rfind("sys_", 0) == 0;
      if (!mine && !common) continue;
      if (e.id == "mag_gradient" && s.has_position)
        subtract_gradient(s, e), done = true;
      else if (e.id == "gyr_earth")
        done = subtract_earth(s, e, s.latitude_rad) || done;
      else if (subtract_timing(s, k, e) || (mine && (subtract_line(s, k, e) || subtract_linear(s, k, e, tracker))))
        done = true;
    }
    if (!done) unknown.push_back(e.id);
  }
  return unknown;
}

}  // namespace stillpoint::diag
