/// Directions on a sphere as two discs, drawn while the page is written.
#pragma once
#include <string>
#include <vector>

#include "core/types.h"

namespace stillpoint::app {

struct MarkedDirection {
  Vec3 direction;      ///< of unit length, axes of the sensor
  std::string tip;     ///< what the mark tells when it is pointed at, text
  double share = 0.0;  ///< 0 to 1: how deep its colour is
};

/// Both halves of the sphere, seen along z, equal areas alike (Lambert); the rim of each is z = 0. An SVG element.
[[nodiscard]] std::string sphere_svg(const std::vector<MarkedDirection>& directions);

}  // namespace stillpoint::app
