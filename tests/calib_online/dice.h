#pragma once

#include <random>

#include "core/so3.h"

namespace stillpoint::calib {

class Dice {
 public:
  explicit Dice(unsigned seed) : engine_(seed) {}
  /// One draw a line: in which order the arguments of a call are evaluated is the compiler's choice.
  Vec3 normal3(double sd = 1.0) {
    const double z = normal_(engine_);
    const double y = normal_(engine_);
    return sd * Vec3(normal_(engine_), y, z);
  }
  Quat rotation() { return exp_quat(normal3(2.0)); }

 private:
  std::mt19937 engine_;
  std::normal_distribution<double> normal_;
};

}  // namespace stillpoint::calib
