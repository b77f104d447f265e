#include "diagnosis/prove/kinds.h"

#include <algorithm>
#include <map>
#include <set>

#include "diagnosis/prove/prove.h"

namespace stillpoint::diag {
namespace {

/// Effects by how their size is set: scaled to a d', or drawn from the usual range of their parameters.
const std::vector<std::string> kScaled{
    "acc_temp_lin",   "acc_temp_quad", "acc_temp_scale", "acc_temp_lag",  "acc_lever",     "acc_quad",
    "acc_cubic",      "acc_asym",      "acc_volt",       "gyr_temp_lin",  "gyr_temp_quad", "gyr_temp_lag",
    "gyr_temp_scale", "gyr_gsens",     "gyr_cubic",      "gyr_asym",      "gyr_volt",      "mag_temp_lin",
    "mag_temp_scale", "mag_hard_step", "mag_field_step", "mag_soft_step", "mag_gradient",  "mag_current"};
const std::vector<std::string> kDrawn{"acc_lpf", "acc_delay", "gyr_lpf",  "gyr_delay", "mag_delay", "sys_offset",
                                      "sys_gap", "sys_dup",   "mag_hold", "gyr_quant", "acc_sat",   "gyr_sat"};
const std::vector<std::string> kWithoutReference{"gyr_temp_lin",   "gyr_temp_quad", "gyr_gsens",    "gyr_volt",
                                                 "gyr_cubic",      "gyr_asym",      "mag_temp_lin", "mag_hard_step",
                                                 "mag_field_step", "mag_current",   "mag_delay",    "mag_temp_scale"};
const std::vector<std::string> kThermal{"acc_temp_lin", "gyr_temp_lin", "mag_temp_lin", "gyr_temp_quad",
                                        "acc_temp_quad"};
const std::vector<std::string> kAbsorbed{"gyr_temp_lin", "gyr_temp_quad", "gyr_temp_lag"};
const std::vector<std::string> kWeak{"acc_temp_lin", "acc_volt", "acc_asym",     "gyr_temp_lin",
                                     "gyr_asym",     "gyr_volt", "mag_temp_lin", "mag_current"};
const std::vector<std::string> kElectrical{"mag_current", "gyr_volt", "acc_volt"};

}  // namespace

std::string kind_of(std::size_t index) {
  // Of three in forty the library lacks the law, or an estimator has absorbed it.
  static const std::map<std::size_t, std::string> rare{{9, "deleted"}, {14, "absorb"}, {25, "deleted"}};
  if (const auto at = rare.find(index % kSlots); at != rare.end()) return at->second;
  // Twenty slots: three clean, three outside the library, the rest shared by the ways to conceal.
  static const std::vector<std::string> slots{"clean",  "single", "pair",   "novel",   "window", "single", "noref",
                                              "clean",  "cfgerr", "single", "novel",   "notemp", "pair",   "confound",
                                              "single", "window", "clean",  "oneaxis", "noaux",  "novel"};
  return slots[index % slots.size()];
}

std::vector<std::string> kinds_of_cases() {
  std::set<std::string> kinds;
  for (std::size_t index = 0; index < kSlots; ++index) kinds.insert(kind_of(index));
  return {kinds.begin(), kinds.end()};
}

Range range_of(const std::string& kind) {
  constexpr Range kUsual{12.0, 120.0}, kWeakest{2.5, 14.0};
  return kind == "limit" ? kWeakest : kUsual;
}

bool is_scaled(const std::string& id) { return std::find(kScaled.begin(), kScaled.end(), id) != kScaled.end(); }

std::vector<std::string> effects_of(Draw& draw, const std::string& kind) {
  if (kind == "clean" || kind == "novel") return {};
  if (kind == "notemp" || kind == "confound") return {draw.one_of(kThermal)};
  if (kind == "noaux") return {draw.one_of(kElectrical)};
  if (kind == "absorb") return {draw.one_of(kAbsorbed), "sys_tracker"};
  if (kind == "deleted") return {draw.one_of(kScaled)};
  if (kind == "limit") return {draw.one_of(kWeak)};
  if (kind == "noref") return {draw.one_of(kWithoutReference)};
  if (kind == "window") {
    static const std::vector<std::string> lasting{"acc_quad",      "acc_lever",      "gyr_gsens",  "gyr_asym",
                                                  "mag_hard_step", "mag_field_step", "mag_current"};
    return {draw.one_of(lasting)};
  }
  if (kind == "oneaxis" || kind == "cfgerr") {
    static const std::vector<std::string> diagonal{"acc_quad",     "acc_asym",  "acc_temp_lin", "gyr_asym",
                                                   "gyr_temp_lin", "gyr_cubic", "mag_temp_lin", "mag_current"};
    return {draw.one_of(diagonal)};
  }
  if (kind == "pair") {
    const std::string first = draw.one_of(kScaled);
    std::string second = first;
    while (second.substr(0, 3) == first.substr(0, 3)) second = draw.one_of(kScaled);
    return {first, second};
  }
  return {draw.bits() % 3 == 0 ? draw.one_of(kDrawn) : draw.one_of(kScaled)};
}

}  // namespace stillpoint::diag
