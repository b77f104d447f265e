#include "simulation/effect_catalogue.h"

#include <algorithm>
#include <array>
#include <tuple>

#include "simulation/effect_families.h"

namespace stillpoint::sim {
namespace {

/// Sensor by sensor; in a sensor its own entries (A1, A2, ...) before those shared by all (T2, ...) and borrowed (G14).
auto place_in_catalogue(const EffectInfo& e) {
  constexpr std::array<std::string_view, 5> kSections{"acc", "gyr", "mag", "sys", "ref"};
  constexpr std::string_view kOwn = "AGMTT";
  const auto section = std::find(kSections.begin(), kSections.end(), e.sensor) - kSections.begin();
  const int foreign = e.entry[0] == kOwn[static_cast<std::size_t>(section)] ? 0 : e.entry[0] == 'T' ? 1 : 2;
  return std::tuple(section, foreign, std::stoi(e.entry.substr(1)));
}

}  // namespace

const EffectParameter* EffectInfo::parameter(std::string_view key) const {
  const auto it = std::find_if(parameters.begin(), parameters.end(), [&](const auto& p) { return p.key == key; });
  return it == parameters.end() ? nullptr : &*it;
}

bool EffectInfo::takes_sensors() const { return (sensor == "sys" && id != "sys_tracker") || id == "ref_frame"; }

const std::vector<EffectInfo>& effect_catalogue() {
  static const std::vector<EffectInfo> table = [] {
    std::vector<EffectInfo> all;
    for (const auto& part : {families_of_several_sensors(), families_of_one_sensor(), families_of_the_system()})
      for (const Family& family : part)
        for (const EffectInfo& effect : family.effects()) all.push_back(effect);
    std::stable_sort(all.begin(), all.end(),
                     [](const auto& a, const auto& b) { return place_in_catalogue(a) < place_in_catalogue(b); });
    return all;
  }();
  return table;
}

const EffectInfo* find_effect(std::string_view id) {
  const auto& all = effect_catalogue();
  const auto it = std::find_if(all.begin(), all.end(), [&](const EffectInfo& e) { return e.id == id; });
  return it == all.end() ? nullptr : &*it;
}

}  // namespace stillpoint::sim
