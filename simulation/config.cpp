#include "simulation/config.h"

#include <cmath>

namespace stillpoint::sim {

const std::vector<std::string>& motion_kind_names() {
  static const std::vector<std::string> names{"rest_poses", "hand", "turntable", "tumble",  "walking",
                                              "vehicle",    "boat", "drone",     "worn_day"};
  return names;
}

double normal_gravity_mps2(double latitude_rad, double height_m) {
  constexpr double kSemiMajor_m = 6378137.0, kFlattening = 1.0 / 298.257223563, kRatio_m = 0.00344978650684;
  const double s2 = std::sin(latitude_rad) * std::sin(latitude_rad);
  const double surface = 9.7803253359 * (1.0 + 0.00193185265241 * s2) / std::sqrt(1.0 - 0.00669437999013 * s2);
  const double h = height_m / kSemiMajor_m;
  return surface * (1.0 - 2.0 * (1.0 + kFlattening + kRatio_m - 2.0 * kFlattening * s2) * h + 3.0 * h * h);
}

}  // namespace stillpoint::sim
