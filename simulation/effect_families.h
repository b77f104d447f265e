/// How the catalogue is written down: a kind of effect once, with the sensors that have it. In its texts {s} stands for
/// the sensor's prefix ("acc"), {u} for its unit in keys ("mps2"), {U} for its unit ("m/s^2"), {v} for its vector
/// ("f"), {signal} for what it senses ("specific force") and {name} for the sensor ("accelerometer").
#pragma once
#include <string>
#include <vector>

#include "simulation/effect_catalogue.h"

namespace stillpoint::sim {

class Family {
 public:
  Family(std::string kind, std::string title, std::string equation);

  Family& driven_by(std::string driver, std::string excited_by);
  Family& mistaken_for(std::string others, std::string told_apart_by);
  /// `count` 1, 3 or 9 numbers, usually between `low` and `high`; of the first parameter `in` says the range.
  Family& takes(std::string key, std::string symbol, std::string unit, int count, double low = 0.0, double high = 0.0);
  Family& may_take(std::string key, std::string symbol, std::string unit, int count, double fallback);
  /// A sensor (acc, gyr, mag, sys, ref) that has it, its place in the catalogue, the usual size of the first parameter.
  Family& in(const std::string& sensor, const std::string& entry, double low = 0.0, double high = 0.0);

  [[nodiscard]] std::vector<EffectInfo> effects() const;

 private:
  struct Member {
    std::string sensor, entry;
    double low, high;
  };
  EffectInfo common_;  ///< the ID is the kind alone, the texts hold their placeholders
  std::vector<Member> members_;
};

[[nodiscard]] std::vector<Family> families_of_several_sensors();
[[nodiscard]] std::vector<Family> families_of_one_sensor();
[[nodiscard]] std::vector<Family> families_of_the_system();

}  // namespace stillpoint::sim
