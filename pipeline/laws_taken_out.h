/// Laws outside the catalogue (docs/discovery.md) taken out of the readings: functions of rate, force, field and
/// temperature at that very moment. Whoever reads the configuration makes them from its text.
#pragma once
#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "core/types.h"

namespace stillpoint::pipeline {

/// What a law may depend on, in the sensor's frame: m/s^2, rad/s, uT, degC.
struct Momentary {
  Vec3 force = Vec3::Zero(), rate = Vec3::Zero(), field = Vec3::Zero();
  double temp_degC = 0.0;
};

struct TakenOutLaw {
  Vec3 Momentary::*of = nullptr;                ///< the vector that the law adds to
  std::function<Vec3(const Momentary&)> delta;  ///< keeps nothing, does not throw or allocate
};

/// None, or laws that all copies of the stages share: copying them allocates nothing.
using TakenOutLaws = std::shared_ptr<const std::vector<TakenOutLaw>>;

/// `read` = true vectors plus what the laws add to them; gives the true ones. A law that has no value there (a quotient
/// by zero) adds nothing.
[[nodiscard]] inline Momentary without_laws(const TakenOutLaws& laws, const Momentary& read) {
  if (!laws) return read;
  constexpr int kPasses = 4;  // laws are per mille of what they depend on; each pass gains three digits
  Momentary now = read;
  for (int pass = 0; pass < kPasses; ++pass) {
    const Momentary drivers = std::exchange(now, read);
    for (const TakenOutLaw& law : *laws)
      if (const Vec3 delta = law.delta(drivers); delta.allFinite()) now.*law.of -= delta;
  }
  return now;
}

}  // namespace stillpoint::pipeline
