/// The reference columns of a simulated recording: the true pose with the errors of what measured it.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "simulation/active_effect.h"
#include "simulation/noise.h"

namespace stillpoint::sim {

class Reference {
 public:
  /// Errors of `reference: {kind: mocap}` and, beside them, of every effect ref_error; each has its own random numbers.
  Reference(const SimulationConfig& config, std::uint64_t seed);

  /// Puts this row's errors on the true pose: orientation about the body's axes, position along the world's.
  void disturb(double row_t_s, Quat& q_world_body, Vec3& position_m) noexcept;

 private:
  struct Errors {
    BandNoise orientation_rad, position_m;
    std::vector<ActiveEffect> of;  ///< the effect they belong to; none: the configured reference, always there
    Errors(double orientation_sd, double position_sd, double band_hz, double step_s, std::uint64_t seed,
           const std::string& source)
        : orientation_rad(orientation_sd, band_hz, step_s, seed, source + " orientation"),
          position_m(position_sd, band_hz, step_s, seed, source + " position") {}
  };
  std::vector<Errors> errors_;
};

}  // namespace stillpoint::sim
