#include "diagnosis/reference/engine.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "diagnosis/reference/evidence.h"
#include "diagnosis/reference/jitter.h"
#include "diagnosis/reference/sensors_at_once.h"
#include "diagnosis/reference/settled_matrices.h"
#include "diagnosis/reference/steadiness.h"
#include "diagnosis/reference/timing_in_window.h"

namespace stillpoint::diag {
namespace {

constexpr int kMostEffects = 3;    // of one sensor
constexpr int kMostSettlings = 2;  // of the matrices: the first is of a law that was fitted through the wrong ones
constexpr int kMostTimings = 2;    // of the rows, where their times deviate: the first is of laws that were too small
constexpr double kClearNats = 3.0;

bool concerns_the_clock(const Found& f) {
  return f.kind == Kind::kTiming &&
         (f.id.find("delay") != std::string::npos || f.id == "sys_gap" || f.id == "sys_skew");
}

/// The same timing law with the same numbers in another sensor.
std::optional<Series3> same_offset(const Signals& s, Sensor sensor, const Found& f) {
  const std::string id = f.id.rfind("sys_", 0) == 0 ? f.id : std::string(kSensorName[sensor]) + "_delay";
  for (const TimingLaw& law : make_timing_laws(s, sensor, f.window.begin))
    if (law.id == id) return in_window(law, f.window).delta(f.timing);
  return std::nullopt;
}

/// Whether a delay of the sensor's own explains clearly more than the common one: then it is not common.
bool has_its_own(const Signals& s, const SensorSearch& search, const Window& window, double common_gain) {
  constexpr double kClearShare = 0.1;
  const Columns explained = search.explained();
  const NoiseModel noise(search.target.layout, fit_profile(search.target, explained).leftover);
  for (const TimingLaw& law : make_timing_laws(s, search.sensor, 0)) {
    if (!law.id.ends_with("_delay")) continue;
    const TimingFit own = fit_timing(search.target, explained, noise, in_window(law, window));
    if (own.gain_nats <= 0) return false;
    const double gain = gain_of_offset(search, own.delta);
    return gain > common_gain + std::max(kClearNats, kClearShare * gain);
  }
  return false;
}

/// A delay for a while that is one of many: the sensor is late outside of it as well, or by other times within it. One
/// that lasts to the end is rows that are lost, for which there is a law.
bool is_a_piece(const Signals& s, const SensorSearch& search, const Found& f) {
  if (f.window.end >= s.n) return true;
  SensorSearch beside = search;
  accept(beside, f);
  Found throughout = f;
  throughout.window = {};
  const auto late = same_offset(s, search.sensor, throughout);
  return !late || is_late_elsewhere(beside, *late);
}

enum class Shared { kNo, kYes, kForAWhile };

/// Whether the other sensors confirm it; takes the offset out of them when they do, unless it is one for a while.
Shared shared_by_all(const Signals& s, EngineResult& r, Sensor lead, Found& f, std::vector<Sensor>& sensors) {
  std::array<std::optional<Series3>, kSensors> offsets;
  std::array<double, kSensors> gains{};
  double total = 0.0;
  for (const Sensor other : {kAcc, kGyr, kMag}) {
    if (other == lead || !r.sensor[other]) continue;
    offsets[other] = same_offset(s, other, f);
    if (!offsets[other]) continue;
    gains[other] = gain_of_offset(*r.sensor[other], *offsets[other]);
    if (f.id.ends_with("_delay") && has_its_own(s, *r.sensor[other], f.window, gains[other])) return Shared::kNo;
    total += gains[other];
  }
  const bool must_be_common = f.id.rfind("sys_", 0) == 0;
  if (total < (must_be_common ? -kClearNats : kClearNats)) return Shared::kNo;
  if (f.window.local && !must_be_common && is_a_piece(s, *r.sensor[lead], f)) return Shared::kForAWhile;
  for (const Sensor other : {kAcc, kGyr, kMag}) {
    if (!offsets[other]) continue;
    r.sensor[other]->target.residual -= *offsets[other];
    r.sensor[other]->first_gain = std::max(r.sensor[other]->first_gain, gains[other]);
    sensors.push_back(other);
  }
  if (!must_be_common) f.id = "sys_offset";
  // The others are late as well.
  std::erase_if(f.rivals, [](const Ranked& rival) { return rival.id.ends_with("_delay"); });
  return Shared::kYes;
}

/// Index of the sensor's own delay, all the time, among what was found.
std::optional<std::size_t> own_delay(const SensorSearch& search) {
  const std::string id = std::string(kSensorName[search.sensor]) + "_delay";
  for (std::size_t i = 0; i < search.found.size(); ++i)
    if (search.found[i].id == id && !search.found[i].window.local) return i;
  return std::nullopt;
}

struct Late {
  Sensor sensor = kGyr;
  std::size_t at = 0;  ///< among what was found in it
  double tau_s = 0.0, sd_s = 0.0;
};

/// Where sensors were found late by the same time, but before what else they show was found, and no other denies it, it
/// is the clock. No sensor tells what has yet to come: one that is early stands beside a reference that is late, and
/// those that are later than it have so much of their own.
void join_delays(const Signals& s, EngineResult& r) {
  constexpr double kSame = 3.0;  // deviations
  std::vector<Late> all;
  std::vector<SensorSearch*> others;
  for (auto& search : r.sensor) {
    if (!search) continue;
    const auto at = own_delay(*search);
    if (!at) {
      others.push_back(&*search);
      continue;
    }
    const Finished finished = finish(*search);
    const Eigen::Index column = first_column(*search, *at);
    all.push_back({search->sensor, *at, finished.values[column], finished.sd[column]});
  }
  if (all.empty()) return;
  const auto earlier = [](const Late& a, const Late& b) { return a.tau_s < b.tau_s; };
  const Late earliest = *std::min_element(all.begin(), all.end(), earlier);
  const auto agrees = [](const Late& a, const Late& b) {
    return std::abs(a.tau_s - b.tau_s) <= kSame * std::hypot(a.sd_s, b.sd_s);
  };
  const auto own = std::stable_partition(all.begin(), all.end(), [&](const Late& l) { return agrees(l, earliest); });
  const bool alone = own - all.begin() == 1;
  if (earliest.tau_s > 0.0 && (alone || own != all.end())) return;
  std::sort(all.begin(), own, [](const Late& a, const Late& b) { return a.sd_s < b.sd_s; });
  const Late lead = all.front();
  Found& f = r.sensor[lead.sensor]->found[lead.at];
  std::vector<std::pair<SensorSearch*, Series3>> unseen;
  for (SensorSearch* other : others) {
    auto offset = same_offset(s, other->sensor, f);
    if (!offset) continue;
    if (gain_of_offset(*other, *offset) < -kClearNats) return;
    unseen.emplace_back(other, std::move(*offset));
  }
  std::vector<Sensor> sensors{lead.sensor};
  for (const auto& [other, offset] : unseen) {
    other->target.residual -= offset;
    sensors.push_back(other->sensor);
  }
  for (auto l = all.begin() + 1; l != all.end(); ++l) {
    SensorSearch& other = *r.sensor[l->sensor];
    sensors.push_back(l->sensor);
    if (l < own) take_out(other, l->at);
    if (const auto offset = same_offset(s, l->sensor, f)) other.target.residual -= *offset;
  }
  f.id = "sys_offset";
  std::erase_if(f.rivals, [](const Ranked& rival) { return rival.id.ends_with("_delay"); });
  r.system.push_back({f, lead.sensor, sensors});
}

struct Search {
  EngineResult result;
  std::array<bool, kSensors> open{};
};

Search begin(const Signals& s, const std::vector<std::string>& without) {
  Search out;
  for (const Sensor k : {kAcc, kGyr, kMag}) {
    if (!s.compared(k)) continue;
    out.result.sensor[k] = start_search(s, k, without);
    out.open[k] = out.result.sensor[k]->target.layout.used() > 200;
  }
  return out;
}

/// The next effect of each sensor.
void one_round(const Signals& s, Search& search) {
  EngineResult& r = search.result;
  std::array<std::optional<Found>, kSensors> next;
  sensors_at_once(s, [&](Sensor k) {
    if (search.open[k]) next[k] = next_effect(s, *r.sensor[k]);
  });
  // The sensor that sees a clock effect best speaks for it.
  int lead = -1;
  for (int k = 0; k < kSensors; ++k)
    if (next[k] && concerns_the_clock(*next[k]) && (lead < 0 || next[k]->gain_nats > next[lead]->gain_nats)) lead = k;
  std::array<bool, kSensors> again{};
  if (lead >= 0) {
    std::vector<Sensor> sensors{static_cast<Sensor>(lead)};
    const Shared shared = shared_by_all(s, r, static_cast<Sensor>(lead), *next[lead], sensors);
    if (shared == Shared::kForAWhile) {  // a piece of a latency that varies, for which there are laws
      for (auto& of_sensor : r.sensor)
        if (of_sensor) of_sensor->delays_in_windows = false;
      return;
    }
    if (shared == Shared::kYes) {
      r.system.push_back({*next[lead], static_cast<Sensor>(lead), sensors});
      for (const Sensor k : sensors) again[k] = k != lead;
    }
  }
  for (const Sensor k : {kAcc, kGyr, kMag}) {
    if (again[k]) continue;  // its residual has changed: look afresh in the next round
    if (!next[k])
      search.open[k] = false;
    else
      accept(*r.sensor[k], *next[k]);
  }
}

}  // namespace

EngineResult search_all(Signals& s, const std::vector<std::string>& without,
                        const std::function<void(double)>& progress) {
  Search search = begin(s, without);
  int round = 0, settled = 0, timed = 0;
  double done = 0.0;  // what begins anew is not done again
  while (round < kMostEffects) {
    if (progress) progress(done = std::max(done, static_cast<double>(round) / kMostEffects));
    one_round(s, search);
    ++round;
    const bool settles = settled < kMostSettlings && settle_matrices(s, search.result);
    const bool times = !settles && round == kMostEffects && timed < kMostTimings && time_rows_again(s, search.result);
    if (!settles && !times) continue;
    settled += settles, timed += times;
    search = begin(s, without);
    round = 0;
  }
  join_delays(s, search.result);
  return std::move(search.result);
}

}  // namespace stillpoint::diag
