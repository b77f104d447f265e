#include "diagnosis/reference/findings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "diagnosis/discovery/law_entry.h"
#include "diagnosis/discovery/law_words.h"
#include "diagnosis/finding_effect.h"
#include "diagnosis/reference/adequacy.h"
#include "diagnosis/reference/clock_law.h"
#include "diagnosis/reference/clock_of_rows.h"
#include "diagnosis/reference/columns.h"
#include "diagnosis/reference/curves.h"
#include "diagnosis/reference/drift.h"
#include "diagnosis/reference/finding_of_law.h"
#include "diagnosis/reference/given_effects.h"
#include "diagnosis/reference/left_at_rest.h"
#include "diagnosis/reference/lines.h"
#include "diagnosis/reference/nameless.h"
#include "diagnosis/reference/remainder.h"
#include "diagnosis/reference/steadiness.h"
#include "diagnosis/reference/unrecorded.h"
#include "diagnosis/reference/wandering_reference.h"

namespace stillpoint::diag {
namespace {

constexpr double kLeftOver = 0.2;  // of the gain of the stronger effect
// Of 649 names on eleven sets three were less sure than this, all untrue; the least sure true one was at 6e-4.
constexpr double kByChance = 1e-3;

/// What a stronger effect leaves in its own window, or at its edges: no second event.
bool left_of_another(const SensorSearch& search, const Found& f) {
  return std::any_of(search.found.begin(), search.found.end(), [&f](const Found& other) {
    const bool overlap = std::max(f.window.begin, other.window.begin) < std::min(f.window.end, other.window.end);
    return other.window.local && overlap && f.gain_nats < kLeftOver * other.gain_nats;
  });
}

bool holds(const SensorSearch& search, const std::string& part) {
  return std::any_of(search.found.begin(), search.found.end(),
                     [&part](const Found& f) { return f.id.find(part) != std::string::npos; });
}

void say_as_unknown(Finding& f, const char* name, const char* driver) {
  f.effect = name;
  f.driver = driver;
  f.equivalent.clear();
  f.wider.reset();
  f.decided_by = "record what changes it";
}

/// What rounding to steps as coarse as the noise does follows the motion. Noise of sd before the rounding leaves an
/// error of step / pi exp(-2 (pi sd / step)^2) in the mean, at most (Widrow & Kollár, Quantization Noise); a product
/// outside the catalogue is free enough to take the rounding itself for one.
bool is_the_lattice(const Signals& s, const Found& f, Sensor k, const HeldOut& h) {
  const double step = s.lattice_step[k], noise_sd = std::min(s.noise_sd[k], h.rms_after),
               before = noise_sd * noise_sd - step * step / 12.0;
  if (step < noise_sd) return false;
  const double removed = h.rms_before * h.rms_before - h.rms_after * h.rms_after;
  if (is_unknown(f.id)) return removed < step * step / 12.0;
  using std::numbers::pi;
  const double bias = step / pi * std::exp(-2.0 * pi * pi * std::max(before, 0.0) / (step * step));
  return removed < 0.5 * bias * bias;
}

/// What is stated of a sensor: no number of it is fitted beside a law that is not.
struct Stated {
  SensorSearch search;
  Finished finished;
  std::vector<HeldOut> held_out;  ///< of each law
};

/// Beside the other laws a number may go where no sensor has it: then it only takes out what they brought in.
bool has_possible_numbers(const SensorSearch& search, std::size_t index, const Finished& finished) {
  const Found& f = search.found[index];
  const auto first = first_column(search, index);
  if (f.names == kWholeOrNothing) return is_share_of_a_whole(finished.values[first]);
  return !f.possible || f.possible(finished.values.segment(first, f.timing.size()));
}

/// What all of the laws together leave to a law of which no number is three of its deviations from zero is nothing.
bool shows_nowhere(const SensorSearch& search, std::size_t index, const Finished& finished) {
  const Eigen::Index first = first_column(search, index);
  const auto count = static_cast<Eigen::Index>(search.found[index].columns.size());
  return count > 0 &&
         (finished.values.segment(first, count).array().abs() < 3.0 * finished.sd.segment(first, count).array()).all();
}

bool is_the_jitters_chance(const Signals& s, const SensorSearch& search, std::size_t index, const Finished& finished) {
  constexpr double kDeviations = 4.0;
  const Eigen::VectorXd chance = chance_by_jitter(s, search.found[index], search.target.layout);
  const auto numbers = finished.values.segment(first_column(search, index), chance.size()).array();
  return chance.size() > 0 && (numbers.abs() < kDeviations * chance.array()).all();
}

/// Why a law that was found is not stated, in words; empty: it is, with what it does on motion left out of its fit.
std::string why_not(const Signals& s, const SensorSearch& search, std::size_t index, const Finished& finished,
                    HeldOut& held_out) {
  const Found& f = search.found[index];
  if (!has_possible_numbers(search, index, finished)) return "its numbers are none that a sensor has";
  if (f.kind == Kind::kConfiguration) return "";
  if (shows_nowhere(search, index, finished))
    return "beside what else was found, none of its numbers is known from zero";
  if (is_the_jitters_chance(s, search, index, finished)) return "so many deviations in time are as much by chance";
  if (const double chance = chance_of(search, f); chance > kByChance)
    return fmt::format("of as many hypotheses one fits as well by chance, once in {:.0f} recordings", 1.0 / chance);
  held_out = held_out_by_regime(search, {index});
  if (fails_elsewhere(held_out, f.id))
    return fmt::format("on {} left out of its fit it removes {:.2g} of what is removable", held_out.on,
                       held_out.removable_share_removed);
  if (is_the_lattice(s, f, search.sensor, held_out))
    return "the steps of the readings, as coarse as their noise, leave as much";
  return "";
}

Stated stated_of(const Signals& s, const SensorSearch& search, const Finished& finished,
                 std::vector<std::string>& notices) {
  Stated out{search, finished, {}};
  for (std::size_t i = 0; i < search.found.size(); ++i) {
    HeldOut held_out;
    const std::string why = why_not(s, search, i, finished, held_out);
    if (why.empty()) {
      out.held_out.push_back(std::move(held_out));
      continue;
    }
    notices.push_back(fmt::format("{} fits, but is not stated: {}", search.found[i].id, why));
    take_out(out.search, out.held_out.size());
  }
  if (out.held_out.size() < search.found.size()) out.finished = finish(out.search);
  return out;
}

/// Some product of drivers goes along with a camera's own errors for a while, and with its turns; of its fit it then
/// predicts half. An offset or a line for a while is what a vibration does that the camera does not see.
void drop_whiles_of_a_camera(const Signals& s, SensorSearch& search, std::vector<std::string>& notices) {
  if (s.exact_reference) return;
  const auto for_a_while = [](const Found& f) {
    return f.window.local && (f.id == kPlainOffset || f.id.ends_with("_alias"));
  };
  const auto vibrates = [&] {
    return s.shaken[search.sensor] || holds(search, kBodyVibration) ||
           swings_at_rest(s, search, finish_beside_drift(search));
  };
  if (std::any_of(search.found.begin(), search.found.end(), for_a_while) && vibrates()) {
    notices.push_back(fmt::format("{}: what fits for a while is not stated: the body vibrates unseen by the reference",
                                  kSensorName[search.sensor]));
    for (std::size_t i = search.found.size(); i-- > 0;)
      if (for_a_while(search.found[i])) take_out(search, i);
  }
  for (std::size_t i = search.found.size(); i-- > 0;) {
    const Found f = search.found[i];
    const bool blames_nothing = f.id == kPlainOffset || f.id == kUnrecordedScalar;
    if (f.kind != Kind::kUnknown || !f.window.local || blames_nothing) continue;
    const HeldOut h = held_out_by_regime(search, {i});
    SensorSearch without = search;
    take_out(without, i);
    if (!is_unsure(h) && stands_beside_wandering(s, without, f)) continue;
    notices.push_back(
        fmt::format("{} fits, but is not stated: a reference that wanders does as much for a while", f.id));
    search = std::move(without);
  }
}

void widen_by_jitter(const Signals& s, const SensorSearch& search, Finished& finished) {
  for (std::size_t i = 0; i < search.found.size(); ++i) {
    const Eigen::VectorXd chance = chance_by_jitter(s, search.found[i], search.target.layout);
    auto sd = finished.sd.segment(first_column(search, i), chance.size()).array();
    sd = (sd.square() + chance.array().square()).sqrt();
  }
}

/// A log's clock is known from how it turns, to a small part of a step: what is later by less is not the sensor's. A
/// camera's goes along with the sensors' to a fraction of a millisecond at best.
bool within_the_alignment(const Signals& s, const Found& f, const Eigen::VectorXd& numbers) {
  constexpr double kOfAStep = 4e-3, kCameras_s = 2.5e-4;
  if (f.kind != Kind::kTiming) return false;
  if (s.from_log) return most_late(s, f, numbers) < kOfAStep * s.dt_s;
  return f.id == "sys_skew" && !s.exact_reference && most_late(s, f, numbers) < kCameras_s;
}

/// An offset that stays to the end is the law of a step.
Found as_lasting_law(const Signals& s, Found f) {
  if (f.id != kPlainOffset || !f.window.local || f.window.begin == 0 || f.window.end < s.n) return f;
  f.id = fmt::format("unknown:step(t, {:.6g})", begin_of_row_s(s, f.window.begin) - 0.5 * s.dt_s);
  f.window = {};
  return f;
}

bool has_no_model(const Finding& f) { return is_unknown(f) || f.effect.ends_with("_drift"); }

}  // namespace

int locals(const SensorSearch& search) {
  double lasting = 0.0;
  for (const Found& f : search.found)
    if (!f.window.local) lasting = std::max(lasting, f.gain_nats);
  std::vector<Window> windows;
  for (const Found& f : search.found) {
    const bool no_event = f.kind == Kind::kTiming || f.kind == Kind::kConfiguration;
    if (!f.window.local || no_event || f.gain_nats < lasting || left_of_another(search, f)) continue;
    const auto together = [&f](const Window& w) {
      const auto both = std::min(w.end, f.window.end) - std::max(w.begin, f.window.begin);
      const auto either = std::max(w.end, f.window.end) - std::min(w.begin, f.window.begin);
      return 10 * both > 9 * either;
    };
    if (std::none_of(windows.begin(), windows.end(), together)) windows.push_back(f.window);
  }
  return static_cast<int>(windows.size());
}

void report_sensor(const Signals& s, const EngineResult& engine, Sensor sensor,
                   const std::vector<sim::EffectConfig>& given, Answer& answer) {
  SensorSearch search = *engine.sensor[sensor];
  drop_whiles_of_a_camera(s, search, answer.diagnosis.notices);
  const Finished finished = finish_beside_drift(search);
  std::vector<Finding> findings;
  std::vector<sim::EffectConfig> effects;
  // A step that leaves drift behind, where a driver was not recorded, is more likely a piece of that driver's curve.
  // What follows the temperature beside a step of no known cause is no better: both are slow.
  const bool drifting =
      drifts(search, finished) && !reference_may_drift(s, search, finished) && !walks_as_given(s, sensor, finished);
  const bool slow = drifting || (holds(search, kPlainOffset) && holds(search, "_temp_"));
  const bool piece = slow && locals(search) > 0 && !missing_drivers(s, sensor).empty();
  const bool switched = locals(search) >= 2 || piece;
  if (switched) findings.push_back(switching_finding(finding_from(s, search, 0, finished, {}), s, search));
  Stated stated = switched ? Stated{search, finished, {}} : stated_of(s, search, finished, answer.diagnosis.notices);
  widen_by_jitter(s, stated.search, stated.finished);
  for (std::size_t i = 0; i < stated.held_out.size(); ++i) {
    const Found& f = stated.search.found[i];
    const auto first = first_column(stated.search, i), count = static_cast<Eigen::Index>(f.columns.size());
    const Eigen::VectorXd values = stated.finished.values.segment(first, count);
    if (f.kind == Kind::kConfiguration || within_the_alignment(s, f, values)) continue;
    const Found law = as_lasting_law(s, f);
    // The remainder of an effect already told, here or by the sensor that sees it best, is the same effect.
    const auto same = [&](const Finding& told) { return told.effect == law.id; };
    if (std::any_of(findings.begin(), findings.end(), same)) continue;
    if (std::any_of(answer.diagnosis.findings.begin(), answer.diagnosis.findings.end(), same)) continue;
    Finding told = finding_from(s, stated.search, i, stated.finished, stated.held_out[i]);
    const bool varies = delay_varies(stated.search, i, stated.finished);
    if (varies) say_as_unknown(told, "unknown:delay(t)", "something that delays the rows, now more, now less");
    if (law.id != f.id) told.effect = law.id, told.equation = "delta = k " + law_text(law.id), told.driver = "time";
    if (was_moved(f, s.n)) say_as_unknown(told, "unknown:mounting(t)", "the place of the sensor, or of the marker");
    findings.push_back(std::move(told));
    if (varies) continue;
    if (const auto e = to_effect(f, values, s)) effects.push_back(*e);
    if (const auto e = law_entry(law, sensor, values, stated.finished.sd.segment(first, count))) effects.push_back(*e);
    if (f.shape_name == kTrackerShape)
      effects.push_back({.id = "sys_tracker", .parameters = {{"tau_s", {f.shape}}}, .axes = {}, .window_s = {}});
  }
  // What drifts beside an unknown law is what its product leaves of it.
  // An autoregression may take a large misfit for its own memory: nothing drifts then, and yet the channel is no noise.
  const bool silent = findings.empty() && stated.search.found.empty();
  const auto left = (drifting || silent) && !switched && !stated.search.has_unknown()
                        ? left_over(s, stated.search, stated.finished, answer.diagnosis)
                        : std::nullopt;
  if (left) {
    findings.push_back(remainder_finding(search));
    describe_time(s, *left, findings.back());
  } else if (drifting && !switched && !search.has_unknown() && !contains(given, drift_id(sensor))) {
    findings.push_back(drift_finding(s, search, finished));
    effects.push_back(drift_effect(sensor, finished));
  } else if (std::none_of(findings.begin(), findings.end(), has_no_model)) {
    if (auto wanders = wanders_at_rest(s, search, finished)) findings.push_back(std::move(*wanders));
  }
  tell_swings(s, search, finished, answer.diagnosis);
  if (std::none_of(findings.begin(), findings.end(), [](const Finding& f) { return is_unknown(f); }))
    tell_left_in_motion(s, stated.search, stated.finished, answer.diagnosis);
  if (std::any_of(search.found.begin(), search.found.end(), [](const Found& f) { return is_line(f.id); }))
    without_noise_of(search.sensor, answer.diagnosis);
  for (auto& f : findings) answer.diagnosis.findings.push_back(std::move(f));
  for (auto& e : effects) answer.effects.push_back(std::move(e));
  report_remainder(s, stated.search, stated.finished, answer);
  heat_of(s, search, answer.diagnosis);
  for (const Ranked& r : search.ranking) answer.diagnosis.ranking.push_back({r.id, r.gain_nats});
}

}  // namespace stillpoint::diag
