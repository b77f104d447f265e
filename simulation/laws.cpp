#include "simulation/laws.h"

#include <cmath>
#include <string_view>

#include "core/units.h"
#include "simulation/effect_catalogue.h"

namespace stillpoint::sim {
namespace {

using V = const EffectValues&;
using I = const Instant&;

double tau(I now) { return now.temp_degC - kReferenceTemp_degC; }
Vec3 times(const Vec3& a, const Vec3& b) { return a.cwiseProduct(b); }
Vec3 offset_quadratic(V p, I n) { return tau(n) * (p.vec3(1) + tau(n) * p.vec3(0)); }
Vec3 line(V p, I n) { return std::sin(kTwoPi * p.scalar(1) * n.t_s + p.scalar(2)) * p.vec3(0); }

/// Acceleration of a point at r of a rigid body against its reference point, body frame.
Vec3 rigid_point(const Vec3& r, I n) {
  const Vec3& w = n.motion.rate_radps;
  return n.motion.angular_acceleration_radps2.cross(r) + w.cross(w.cross(r));
}

/// Row i of the parameter is the point at which axis i senses.
Vec3 three_points(V p, I n) {
  const Mat3 points = p.mat3(0);
  return {rigid_point(points.row(0), n).x(), rigid_point(points.row(1), n).y(), rigid_point(points.row(2), n).z()};
}

/// Axes a_i sin(2 pi f t + p_i): the angle two such oscillations rectify about the third axis, and the rate itself.
Vec3 coning(V p, I n) {
  const Vec3 a = p.vec3(0), phase = p.vec3(2);
  const double w = kTwoPi * p.scalar(1);
  Vec3 out;
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    out[i] = 0.5 * w * a[j] * a[k] * std::sin(phase[j] - phase[k]) + a[i] * w * std::cos(w * n.t_s + phase[i]);
  }
  return out;
}

struct Entry {
  std::string_view id;
  Sensor sensor;
  Stage stage;
  Law law;
};

constexpr auto kAtPlace = Stage::kPlace;
constexpr auto kAtElement = Stage::kElement;

const std::vector<Entry>& entries() {
  using enum Sensor;
  static const std::vector<Entry> all{
      {"acc_gravity", kAcc, kAtPlace, [](V p, I n) -> Vec3 { return p.scalar(0) * n.R_body_world.col(2); }},
      {"acc_lever", kAcc, kAtPlace, [](V p, I n) -> Vec3 { return rigid_point(p.vec3(0), n); }},
      {"acc_size", kAcc, kAtPlace, three_points},
      {"ref_frame", kAcc, kAtPlace, [](V p, I n) -> Vec3 { return rigid_point(p.vec3(1), n); }},
      {"acc_alias", kAcc, kAtPlace, line},
      {"gyr_earth", kGyr, kAtPlace,
       [](V p, I n) -> Vec3 {
         const Vec3 measured = p.vec3(1);  // in a world that need not look north
         return n.R_body_world * (measured.isZero() ? Vec3(p.scalar(0) * n.earth_rate_radps) : measured);
       }},
      {"gyr_alias", kGyr, kAtPlace, line},
      {"gyr_coning", kGyr, kAtPlace, coning},
      {"mag_field_step", kMag, kAtPlace,
       [](V p, I n) -> Vec3 { return n.t_s > p.scalar(1) ? Vec3(n.R_body_world * p.vec3(0)) : Vec3::Zero(); }},
      {"mag_gradient", kMag, kAtPlace,
       [](V p, I n) -> Vec3 { return n.R_body_world * (p.mat3(0) * n.motion.position_m + p.vec3(1)); }},

      {"acc_temp_lin", kAcc, kAtElement, [](V p, I n) -> Vec3 { return tau(n) * p.vec3(0); }},
      {"acc_temp_quad", kAcc, kAtElement, offset_quadratic},
      {"acc_temp_scale", kAcc, kAtElement, [](V p, I n) -> Vec3 { return tau(n) * times(p.vec3(0), n.force_mps2); }},
      {"acc_quad", kAcc, kAtElement, [](V p, I n) -> Vec3 { return times(p.vec3(0), n.force_mps2.array().square()); }},
      {"acc_cubic", kAcc, kAtElement, [](V p, I n) -> Vec3 { return times(p.vec3(0), n.force_mps2.array().cube()); }},
      {"acc_asym", kAcc, kAtElement, [](V p, I n) -> Vec3 { return times(p.vec3(0), n.force_mps2.cwiseAbs()); }},
      {"acc_volt", kAcc, kAtElement, [](V p, I n) -> Vec3 { return (n.supply_V - kReferenceSupply_V) * p.vec3(0); }},

      {"gyr_temp_lin", kGyr, kAtElement, [](V p, I n) -> Vec3 { return tau(n) * p.vec3(0); }},
      {"gyr_temp_quad", kGyr, kAtElement, offset_quadratic},
      {"gyr_temp_scale", kGyr, kAtElement, [](V p, I n) -> Vec3 { return tau(n) * times(p.vec3(0), n.rate_radps); }},
      {"gyr_gsens", kGyr, kAtElement, [](V p, I n) -> Vec3 { return p.mat3(0) * n.force_mps2; }},
      {"gyr_cubic", kGyr, kAtElement, [](V p, I n) -> Vec3 { return times(p.vec3(0), n.rate_radps.array().cube()); }},
      {"gyr_asym", kGyr, kAtElement, [](V p, I n) -> Vec3 { return times(p.vec3(0), n.rate_radps.cwiseAbs()); }},
      {"gyr_volt", kGyr, kAtElement, [](V p, I n) -> Vec3 { return (n.supply_V - kReferenceSupply_V) * p.vec3(0); }},

      {"mag_temp_lin", kMag, kAtElement, [](V p, I n) -> Vec3 { return tau(n) * p.vec3(0); }},
      {"mag_temp_scale", kMag, kAtElement, [](V p, I n) -> Vec3 { return tau(n) * times(p.vec3(0), n.field_uT); }},
      {"mag_hard_step", kMag, kAtElement,
       [](V p, I n) -> Vec3 { return n.t_s > p.scalar(1) ? p.vec3(0) : Vec3::Zero(); }},
      {"mag_soft_step", kMag, kAtElement,
       [](V p, I n) -> Vec3 { return n.t_s > p.scalar(1) ? Vec3(p.mat3(0) * n.field_uT) : Vec3::Zero(); }},
      {"mag_current", kMag, kAtElement, [](V p, I n) -> Vec3 { return n.current_A * p.vec3(0); }},
      {"mag_line", kMag, kAtElement, line},
      {"mag_sat", kMag, kAtElement, [](V p, I n) -> Vec3 { return times(p.vec3(1), n.field_uT.array().cube()); }},
  };
  return all;
}

}  // namespace

std::vector<ActiveLaw> laws_for(const std::vector<EffectConfig>& effects, Sensor sensor, Stage stage) {
  std::vector<ActiveLaw> out;
  for (const auto& effect : effects)
    for (const Entry& e : entries()) {
      if (e.id != effect.id || e.sensor != sensor || e.stage != stage) continue;
      if (const ActiveLaw law(effect, e.law); law.covers(sensor)) out.push_back(law);
    }
  return out;
}

Vec3 sum_of(const std::vector<ActiveLaw>& laws, const Instant& now) noexcept {
  Vec3 sum = Vec3::Zero();
  for (const ActiveLaw& l : laws)
    if (l.active(now.t_s)) sum += l.axes.cwiseProduct(l.law(l.values, now));
  return sum;
}

}  // namespace stillpoint::sim
