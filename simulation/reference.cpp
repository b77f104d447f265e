#include "simulation/reference.h"

#include "core/so3.h"

namespace stillpoint::sim {

Reference::Reference(const SimulationConfig& config, std::uint64_t seed) {
  const double step_s = 1.0 / config.rate_hz;
  const auto& r = config.reference;
  if (r.kind == "mocap")
    errors_.emplace_back(r.orientation_sd_rad, r.position_sd_m, r.band_hz, step_s, seed, "reference");
  for (const auto& e : active_effects(config.effects, "ref_error")) {
    const auto& v = e.values;
    errors_.emplace_back(v.scalar(0), v.scalar(1), v.scalar(2), step_s, seed, e.source).of = {e};
  }
}

void Reference::disturb(double row_t_s, Quat& q_world_body, Vec3& position_m) noexcept {
  for (auto& e : errors_) {
    Vec3 turn = e.orientation_rad.next(), shift = e.position_m.next();
    if (!e.of.empty()) {
      if (!e.of.front().active(row_t_s)) continue;
      turn = turn.cwiseProduct(e.of.front().axes);
      shift = shift.cwiseProduct(e.of.front().axes);
    }
    q_world_body = (q_world_body * stillpoint::exp_quat(turn)).normalized();
    position_m += shift;
  }
}

}  // namespace stillpoint::sim
