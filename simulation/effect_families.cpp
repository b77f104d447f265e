#include "simulation/effect_families.h"

#include <map>
#include <utility>

namespace stillpoint::sim {
namespace {

using Words = std::map<std::string, std::string>;

const Words& words_of(const std::string& sensor) {
  static const std::map<std::string, Words> all{
      {"acc",
       {{"{u}", "mps2"},
        {"{U}", "m/s^2"},
        {"{v}", "f"},
        {"{u/f2}", "per_mps2"},
        {"{U/f2}", "1/(m/s^2)"},
        {"{signal}", "specific force"},
        {"{name}", "accelerometer"}}},
      {"gyr",
       {{"{u}", "radps"},
        {"{U}", "rad/s"},
        {"{v}", "w"},
        {"{u/f2}", "radps_per_mps2_2"},
        {"{U/f2}", "rad/s per (m/s^2)^2"},
        {"{signal}", "rate"},
        {"{name}", "gyroscope"}}},
      {"mag", {{"{u}", "uT"}, {"{U}", "uT"}, {"{v}", "m"}, {"{signal}", "field"}, {"{name}", "magnetometer"}}},
      {"sys", {}},
      {"ref", {}}};
  return all.at(sensor);
}

std::string filled(std::string text, const std::string& sensor) {
  const auto replace = [&text](const std::string& mark, const std::string& word) {
    for (std::size_t at = text.find(mark); at != std::string::npos; at = text.find(mark, at + word.size()))
      text.replace(at, mark.size(), word);
  };
  for (const auto& [mark, word] : words_of(sensor)) replace(mark, word);
  replace("{s}", sensor);
  return text;
}

}  // namespace

Family::Family(std::string kind, std::string title, std::string equation) {
  common_.id = std::move(kind);
  common_.title = std::move(title);
  common_.equation = std::move(equation);
}

Family& Family::driven_by(std::string driver, std::string excited_by) {
  common_.driver = std::move(driver);
  common_.excited_by = std::move(excited_by);
  return *this;
}

Family& Family::mistaken_for(std::string others, std::string told_apart_by) {
  common_.mistaken_for = std::move(others);
  common_.told_apart_by = std::move(told_apart_by);
  return *this;
}

Family& Family::takes(std::string key, std::string symbol, std::string unit, int count, double low, double high) {
  common_.parameters.push_back({std::move(key), std::move(symbol), std::move(unit), count, low, high, true, 0.0});
  return *this;
}

Family& Family::may_take(std::string key, std::string symbol, std::string unit, int count, double fallback) {
  common_.parameters.push_back(
      {std::move(key), std::move(symbol), std::move(unit), count, fallback, fallback, false, fallback});
  return *this;
}

Family& Family::in(const std::string& sensor, const std::string& entry, double low, double high) {
  members_.push_back({sensor, entry, low, high});
  return *this;
}

std::vector<EffectInfo> Family::effects() const {
  std::vector<EffectInfo> out;
  for (const auto& [sensor, entry, low, high] : members_) {
    EffectInfo& e = out.emplace_back(common_);
    e.id = sensor + "_" + common_.id;
    e.entry = entry;
    e.sensor = sensor;
    for (std::string* text : {&e.title, &e.equation, &e.driver, &e.excited_by, &e.mistaken_for, &e.told_apart_by})
      *text = filled(*text, sensor);
    for (auto& p : e.parameters)
      for (std::string* text : {&p.key, &p.unit}) *text = filled(*text, sensor);
    if (auto& first = e.parameters.front(); first.required)
      std::tie(first.typical_low, first.typical_high) = std::pair{low, high};
  }
  return out;
}

}  // namespace stillpoint::sim
