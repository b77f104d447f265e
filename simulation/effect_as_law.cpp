#include "simulation/effect_as_law.h"

#include <fmt/format.h>

#include <array>
#include <string>
#include <string_view>

#include "core/so3.h"
#include "core/units.h"
#include "simulation/active_effect.h"
#include "simulation/effect_catalogue.h"
#include "simulation/law_effect.h"

namespace stillpoint::sim {
namespace {

/// One effect and the laws made of it. Its axes and its window are theirs.
class AsLaws {
 public:
  explicit AsLaws(const EffectConfig& effect) : effect_(effect), active_(effect) {}

  [[nodiscard]] const EffectValues& values() const { return active_.values; }
  [[nodiscard]] bool covers(Sensor s) const { return active_.covers(s); }

  void add(Sensor sensor, const std::string& text, const Vec3& k) {
    if (k.isZero()) return;
    const Vec3 shown = active_.axes.cwiseProduct(k);
    entry(sensor, text).parameters["k"] = {shown.data(), shown.data() + 3};
  }
  void add_matrix(Sensor sensor, const std::string& text, const Mat3& M) {
    const RowMajor3 shown = active_.axes.asDiagonal() * M;
    entry(sensor, text).parameters["matrix"] = {shown.data(), shown.data() + 9};
  }
  std::vector<EffectConfig> laws;

 private:
  EffectConfig& entry(Sensor sensor, const std::string& text) {
    laws.push_back({.id = std::string(kLawPrefix) + text, .parameters = {}, .axes = {}, .window_s = effect_.window_s});
    laws.back().sensors = {sensor};
    return laws.back();
  }

  const EffectConfig& effect_;
  ActiveEffect active_;
};

/// A vector of the world, seen from the sensor.
std::string in_world_axes(const std::string& east, const std::string& north, const std::string& up) {
  return fmt::format("({}) * east + ({}) * north + ({}) * up", east, north, up);
}
std::string in_world_axes(const Vec3& b) {
  return in_world_axes(fmt::format("{}", b.x()), fmt::format("{}", b.y()), fmt::format("{}", b.z()));
}

std::string gradient_along(const Mat3& G, const Vec3& b, Eigen::Index row) {
  return fmt::format("{} * p_x + {} * p_y + {} * p_z + {}", G(row, 0), G(row, 1), G(row, 2), b[row]);
}

/// Of the families that several sensors share; `v`: the vector that the sensor measures.
void add_shared(AsLaws& out, Sensor s, std::string_view family, const std::string& v) {
  const EffectValues& p = out.values();
  const std::string tau = fmt::format("T - {}", kReferenceTemp_degC);
  const auto later = [&](double by_s) {
    if (by_s > 0.0) out.add(s, fmt::format("delay({0}, {1}) - {0}", v, by_s), Vec3::Ones());
  };
  if (family == "temp_lin") out.add(s, tau, p.vec3(0));
  if (family == "temp_quad") out.add(s, tau, p.vec3(1)), out.add(s, fmt::format("({})^2", tau), p.vec3(0));
  if (family == "temp_scale") out.add(s, fmt::format("({}) * {}", tau, v), p.vec3(0));
  if (family == "temp_lag") out.add(s, fmt::format("T - lag(T, {})", p.scalar(1)), p.vec3(0));
  if (family == "volt") out.add(s, fmt::format("V - {}", kReferenceSupply_V), p.vec3(0));
  if (family == "quad") out.add(s, fmt::format("{0} * {0}", v), p.vec3(0));
  if (family == "cubic") out.add(s, fmt::format("{0} * {0} * {0}", v), p.vec3(0));
  if (family == "asym") out.add(s, fmt::format("abs({})", v), p.vec3(0));
  if (family == "alias" || family == "line")
    out.add(s, fmt::format("sin({} * t + {})", kTwoPi * p.scalar(1), p.scalar(2)), p.vec3(0));
  if (family == "lpf") out.add(s, fmt::format("lag({0}, {1}) - {0}", v, p.scalar(0)), Vec3::Ones());
  if (family == "delay" || family == "offset") later(p.scalar(0));
}

/// dw/dt x r + w x (w x r), where axis i of the sensor is at r_i, row i.
void add_lever(AsLaws& out, Sensor s, const Mat3& r) {
  Mat3 turning;
  for (int i = 0; i < 3; ++i) turning.row(i) = -skew(Vec3(r.row(i))).row(i);
  out.add_matrix(s, "d(w)", turning);
  for (int i = 0; i < 3; ++i)
    out.add(s, fmt::format("({} * w_x + {} * w_y + {} * w_z) * w", r(i, 0), r(i, 1), r(i, 2)), Vec3::Unit(i));
  out.add(s, "norm(w)^2", -r.diagonal());
}

/// Of those that only one sensor has.
void add_own(AsLaws& out, Sensor s, std::string_view id) {
  const EffectValues& p = out.values();
  const auto from = [](double t0_s) { return fmt::format("step(t, {})", t0_s); };
  if (id == "acc_gravity") out.add(s, "up", Vec3::Constant(p.scalar(0)));
  if (id == "acc_lever") add_lever(out, s, Vec3::Ones() * p.vec3(0).transpose());
  if (id == "acc_size") add_lever(out, s, p.mat3(0));
  if (id == "gyr_gsens") out.add_matrix(s, "f", p.mat3(0));
  if (id == "gyr_earth" && !p.vec3(1).isZero()) out.add(s, in_world_axes(p.vec3(1)), Vec3::Ones());
  if (id == "mag_hard_step") out.add(s, from(p.scalar(1)), p.vec3(0));
  if (id == "mag_soft_step") out.add_matrix(s, from(p.scalar(1)) + " * m", p.mat3(0));
  if (id == "mag_field_step")
    out.add(s, fmt::format("{} * ({})", from(p.scalar(1)), in_world_axes(p.vec3(0))), Vec3::Ones());
  if (id == "mag_current") out.add(s, "I", p.vec3(0));
  if (id == "mag_sat") out.add(s, "m * m * m", p.vec3(1));
  if (id == "mag_gradient") {
    const auto along = [G = p.mat3(0), b = p.vec3(1)](Eigen::Index row) { return gradient_along(G, b, row); };
    out.add(s, in_world_axes(along(0), along(1), along(2)), Vec3::Ones());
  }
}

}  // namespace

std::vector<EffectConfig> as_laws(const EffectConfig& effect) {
  static constexpr std::array kVector{"f", "w", "m"};
  AsLaws out(effect);
  for (const Sensor s : kSensors) {
    if (!out.covers(s) || effect.id.starts_with("ref_")) continue;
    add_shared(out, s, std::string_view(effect.id).substr(4), kVector[static_cast<std::size_t>(s)]);
    add_own(out, s, effect.id);
  }
  return std::move(out.laws);
}

}  // namespace stillpoint::sim
