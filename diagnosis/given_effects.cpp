#include "diagnosis/given_effects.h"

#include <algorithm>
#include <cmath>

#include "simulation/effect_catalogue.h"

namespace stillpoint::diag {
namespace {

constexpr double kPpm = 1e-6;
constexpr double kEarthRate_radps = 7.292115e-5;

std::vector<double> list(const Eigen::VectorXd& v, Eigen::Index first, Eigen::Index count) {
  return {v.data() + first, v.data() + first + count};
}

double scalar(const sim::EffectConfig& e, const std::string& key, double fallback) {
  const auto it = e.parameters.find(key);
  return it == e.parameters.end() || it->second.empty() ? fallback : it->second.front();
}

/// The window in which an entry acts, in samples.
Window window_of(const sim::EffectConfig& e, const Signals& s) {
  Window w;
  const double t0 = scalar(e, "t0_s", 0.0);
  w.begin = std::clamp<Eigen::Index>(std::lround(std::max(t0, e.window_s ? e.window_s->first : 0.0) / s.dt_s), 0, s.n);
  w.end = e.window_s ? std::clamp<Eigen::Index>(std::lround(e.window_s->second / s.dt_s), w.begin, s.n) : s.n;
  w.local = w.begin > 0 || w.end < s.n;
  return w;
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

bool subtract_linear(Signals& s, Sensor k, const sim::EffectConfig& e) {
  bool done = false;
  for (const Law& law : make_laws(s, k)) {
    if (law.id != e.id || law.kind != Kind::kNamed || done) continue;
    const std::vector<double> values = values_for(law, e);
    if (values.empty()) continue;
    if (e.id.find("temp_quad") != std::string::npos && law.coefficients.size() == 3 && e.parameters.size() > 1)
      continue;
    const Columns columns = in_window(law.columns(scalar(e, "tau_s", law.shapes.front())), window_of(e, s));
    for (std::size_t j = 0; j < columns.size(); ++j) {
      const Column& c = columns[j];
      for (int axis = 0; axis < 3; ++axis) {
        const bool acts = e.axes.empty() || std::find(e.axes.begin(), e.axes.end(), axis) != e.axes.end();
        if (const auto shown = shown_in(c, axis); shown && acts) s.residual[k].col(axis) -= values[j] * *shown;
      }
    }
    done = true;
  }
  return done;
}

bool subtract_earth(Signals& s, const sim::EffectConfig& e, double latitude_rad) {
  const Vec3 w = scalar(e, "scale", 1.0) * kEarthRate_radps * Vec3(0.0, std::cos(latitude_rad), std::sin(latitude_rad));
  for (int a = 0; a < 3; ++a) s.residual[kGyr] -= w[a] * s.world_axis[static_cast<std::size_t>(a)];
  return true;
}

std::optional<Eigen::VectorXd> timing_values(const sim::EffectConfig& e, double dt_s) {
  if (e.id == "sys_gap") return Eigen::VectorXd::Constant(1, -scalar(e, "n", 0.0) * dt_s);
  if (e.id == "sys_skew") return Eigen::VectorXd::Constant(1, kPpm * scalar(e, "eps_ppm", 0.0));
  if (e.id.find("resonance") != std::string::npos)
    return Eigen::Vector2d(scalar(e, "f_hz", 100.0), scalar(e, "zeta", 0.1));
  if (e.parameters.count("tau_s") != 0) return Eigen::VectorXd::Constant(1, scalar(e, "tau_s", 0.0));
  return std::nullopt;
}

bool subtract_timing(Signals& s, Sensor k, const sim::EffectConfig& e) {
  const auto values = timing_values(e, s.dt_s);
  if (!values || e.id.find("_temp_") != std::string::npos) return false;
  const std::string id = e.id == "sys_offset" ? std::string(kSensorName[k]) + "_delay" : e.id;
  const Window w = window_of(e, s);
  for (const TimingLaw& law : make_timing_laws(s, k, std::max<Eigen::Index>(w.begin, 1))) {
    if (law.id != id) continue;
    s.residual[k] -= law.delta(*values);
    return true;
  }
  return false;
}

}  // namespace

std::optional<sim::EffectConfig> to_effect(const Found& found, const Eigen::VectorXd& values, double dt_s) {
  const sim::EffectInfo* info = sim::find_effect(found.id);
  if (info == nullptr) return std::nullopt;
  sim::EffectConfig e;
  e.id = found.id;
  const double begin = static_cast<double>(found.window.begin) * dt_s,
               end = static_cast<double>(found.window.end) * dt_s;
  if (found.id == "sys_gap") {
    e.parameters = {{"n", {std::round(-values[0] / dt_s)}}, {"t0_s", {begin}}};
    return e;
  }
  if (found.id == "sys_skew") {
    e.parameters = {{"eps_ppm", {values[0] / kPpm}}};
    return e;
  }
  if (found.id == "gyr_earth") {
    e.parameters = {{"scale", {values.norm() / kEarthRate_radps}}};
    return e;
  }
  if (found.id == "mag_sat" || found.shape_name == kTrackerShape) return std::nullopt;
  Eigen::Index next = 0;
  if (values.size() == 6) {  // temp_quad with its linear part
    for (const auto& p : info->parameters) e.parameters[p.key] = list(values, p.required ? 3 : 0, 3);
    next = 6;
  }
  for (const auto& p : info->parameters) {
    if (p.key == "t0_s")
      e.parameters[p.key] = {begin};
    else if (p.key == found.shape_name + "_s" && !found.shape_name.empty())
      e.parameters[p.key] = {found.shape};
    else if (next + p.count <= values.size())
      e.parameters[p.key] = list(values, next, p.count), next += p.count;
    else if (p.required && e.parameters.count(p.key) == 0)
      return std::nullopt;
  }
  if (found.window.local) e.window_s = {begin, end};
  return e;
}

std::vector<std::string> subtract_effects(Signals& s, const std::vector<sim::EffectConfig>& effects) {
  std::vector<std::string> unknown;
  for (const sim::EffectConfig& e : effects) {
    bool done = false;
    for (const Sensor k : {kAcc, kGyr, kMag}) {
      if (!s.present[k] || s.residual[k].rows() == 0) continue;
      const bool mine = e.id.rfind(std::string(kSensorName[k]) + "_", 0) == 0, common = e.id.rfind("sys_", 0) == 0;
      if (!mine && !common) continue;
      if (e.id == "gyr_earth")
        done = subtract_earth(s, e, s.latitude_rad) || done;
      else if (subtract_timing(s, k, e))
        done = true;
      else if (mine && subtract_linear(s, k, e))
        done = true;
    }
    if (!done) unknown.push_back(e.id);
  }
  return unknown;
}

}  // namespace stillpoint::diag
