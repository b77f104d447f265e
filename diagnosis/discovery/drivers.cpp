#include "diagnosis/discovery/drivers.h"

#include <array>

#include "core/cross_rows.h"
#include "diagnosis/reference/differences.h"
#include "simulation/effect_catalogue.h"

namespace stillpoint::diag {
namespace {

void add_vector(laws::Columns& out, const std::string& name, const Series3& x, const Series3& rate) {
  if (x.rows() == 0) return;
  out.values[name] = x;
  out.values["d(" + name + ")"] = rate;
  for (int axis = 0; axis < 3; ++axis)
    out.values["d(" + name + "_" + kAxisName[static_cast<std::size_t>(axis)] + ")"] = rate.col(axis);
}

/// A noisy reference stands in the residual and in the rate of what is made of it: there the field turns as the
/// gyroscope says.
Series3 rate_of(const Signals& s, Sensor k) {
  if (k != kMag || s.exact_reference) return derivative(s.vector[k], s.rows);
  return cross_rows(s.vector[k], s.rate);
}

}  // namespace

const char* own_vector(Sensor sensor) {
  static constexpr std::array<const char*, kSensors> kOwn{"f", "w", "m"};
  return kOwn[sensor];
}

laws::Columns drivers_of_rows(const Signals& s) {
  laws::Columns out;
  out.t_s = s.t_s;
  add_vector(out, "w", s.rate, s.rate_dot);
  for (const Sensor k : {kAcc, kMag})
    if (s.vector[k].rows() == s.n) add_vector(out, own_vector(k), s.vector[k], rate_of(s, k));
  if (s.has_position && s.position_m.rows() == s.n)
    add_vector(out, "p", s.position_m, derivative(s.position_m, s.rows));
  if (s.temperature_K.size()) out.values["T"] = s.temperature_K.array() + sim::kReferenceTemp_degC;
  if (s.current_A.size()) out.values["I"] = s.current_A;
  if (s.voltage_V.size()) out.values["V"] = s.voltage_V;
  for (const auto& [name, x] : s.user) out.values[name] = x;
  static constexpr std::array<const char*, 3> kWorld{"east", "north", "up"};
  for (std::size_t a = 0; a < kWorld.size(); ++a)
    if (s.world_axis[a].rows() == s.n) out.values[kWorld[a]] = s.world_axis[a];
  return out;
}

}  // namespace stillpoint::diag
