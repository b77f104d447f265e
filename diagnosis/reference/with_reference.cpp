#include "diagnosis/reference/with_reference.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "diagnosis/answer_words.h"
#include "diagnosis/discovery/discover.h"
#include "diagnosis/discovery/law_words.h"
#include "diagnosis/reference/apparatus.h"
#include "diagnosis/reference/findings.h"
#include "diagnosis/reference/given_effects.h"
#include "diagnosis/reference/jitter.h"
#include "diagnosis/reference/lines_in_readings.h"
#include "diagnosis/reference/settled_matrices.h"
#include "diagnosis/reference/slow_look.h"
#include "diagnosis/reference/surplus.h"
#include "diagnosis/reference/twins.h"
#include "diagnosis/summary.h"

namespace stillpoint::diag {
namespace {

constexpr double kShortestRecording_s = 20.0;
constexpr Eigen::Index kLeastRows = 500;  // of a sensor, to say anything of it
constexpr double kMostSamples = 16000.0;  // more are thinned by whole factors, down to the step below
constexpr double kMostTimed = 32000.0;    // of rows that deviate in time: their means are not timed beside laws
constexpr double kFastEnough_s = 0.0201;  // nothing that bodies do needs more than 50 Hz
constexpr const char* kSeenSlowly =
    "{}: looked at in means over {:.1f} s, a row every {:.1f} s: what the reference errs by from row to row hides less "
    "there";

constexpr int kLeastPairs = 200;  // of rows at rest: they tell a deviation to 5 %
constexpr double kLeastOfStated = 0.75,
                 kMostOfStated = 1.3;  // as far as parts of one kind differ from their data sheet

/// White noise of a sensor at rest against the configured one: differences of neighbours do not see the reference.
void compare_noise(const Signals& s, Answer& answer) {
  for (int k = 0; k < kSensors; ++k) {
    if (!s.present[k] || s.noise_sd[k] <= 0) continue;
    for (int axis = 0; axis < 3; ++axis) {
      double sum = 0.0;
      int count = 0;
      for (Eigen::Index i = 1; i < s.n; ++i) {
        const auto at = static_cast<std::size_t>(i);
        if (!s.rest[at] || !s.rest[at - 1] || s.muted[k][at] || s.muted[k][at - 1]) continue;
        const double d = s.residual[k](i, axis) - s.residual[k](i - 1, axis);
        sum += 0.5 * d * d;
        ++count;
      }
      if (count < kLeastPairs) continue;
      const double measured = std::sqrt(sum / count), ratio = measured / s.noise_sd[k];
      if (ratio < kLeastOfStated || ratio > kMostOfStated)
        answer.diagnosis.noise.push_back(
            {fmt::format("{}_{}", kSensorName[static_cast<std::size_t>(k)], kAxisName[static_cast<std::size_t>(axis)]),
             s.noise_sd[k], measured});
    }
  }
}

std::array<Mask, kSensors> masks(const Forensics& forensics) {
  std::array<Mask, kSensors> out;
  for (std::size_t k = 0; k < kSensors; ++k) out[k] = forensics.sensor[k].muted;
  return out;
}

/// A sensor whose noise does not carry it over its steps shows its lattice at rest, not its physics: the mean of what
/// noise of 0.4 steps dithers is right to 0.02 steps, of half of that to 0.15 (Widrow & Kollár, Quantization Noise).
void mute_lattice_at_rest(Signals& s) {
  constexpr double kDither = 0.4;
  for (std::size_t k = 0; k < kSensors; ++k) {
    const double step = s.lattice_step[k];
    if (!s.present[k] || step == 0.0 || s.noise_sd[k] > kDither * step) continue;
    for (std::size_t i = 0; i < s.rest.size(); ++i)
      if (s.rest[i]) s.muted[k][i] = 1;
    s.present[k] = std::count(s.muted[k].begin(), s.muted[k].end(), 0) >= std::min(kLeastRows, s.n / 4);
    if (!s.present[k])
      s.notices.push_back(
          fmt::format("{}: at rest its steps of {:.3g} {} hide all that is smaller; nothing else of it "
                      "is tested. Record motion, or with a smaller range",
                      kSensorName[k], step, kSensorUnit[k]));
  }
}

/// Faults of single readings: their being in the simulation is what silences them; no residual predicts them.
bool shows_in_raw_values(const std::string& id) {
  return id.ends_with("_quant") || id.ends_with("_sat") || id.ends_with("_drift") || id == "mag_hold" ||
         id == "sys_dup" || id == "gyr_deadzone" || id == "sys_jitter" || id == "ref_error" || id == "gyr_instability";
}

/// A law outside the catalogue that leaves only noise in its channels, and foretells most of what it was not fitted to.
bool explains_by_a_law(const Diagnosis& d, const Finding& f) {
  constexpr double kMostOfIt = 0.8;
  if (!f.held_out.on.empty() && f.held_out.removable_share_removed < kMostOfIt) return false;
  return law_tree(f.effect) && std::all_of(d.residual.begin(), d.residual.end(), [&f](const ChannelResidual& r) {
           return r.white || std::find(f.channels.begin(), f.channels.end(), r.channel) == f.channels.end();
         });
}

Verdict verdict_of(const Diagnosis& d) {
  const auto named = [&d](const Finding& f) { return !is_unknown(f) || explains_by_a_law(d, f); };
  const auto lattice = [](const Finding& f) { return f.effect.ends_with("_quant"); };
  const auto names = std::count_if(d.findings.begin(), d.findings.end(), named);
  const auto unknown = std::ssize(d.findings) - names + std::ssize(d.unaccounted);
  if (unknown > 0)
    return std::all_of(d.findings.begin(), d.findings.end(), [&](const Finding& f) { return !named(f) || lattice(f); })
               ? Verdict::kUnexplained
               : Verdict::kPartlyExplained;
  if (names > 0) return Verdict::kExplained;
  if (!d.surplus.empty()) return Verdict::kSurplusPhysics;
  return d.configuration.empty() && d.noise.empty() ? Verdict::kNoMismatch : Verdict::kWrongNumbers;
}

/// Sensors with too few rows beside a whole reference are left out; false when none is left.
bool enough_to_compare(Signals& s) {
  bool any = false;
  for (std::size_t k = 0; k < kSensors; ++k) {
    if (!s.present[k]) continue;
    const auto rows = std::count(s.muted[k].begin(), s.muted[k].end(), 0);
    s.present[k] = rows >= std::min(kLeastRows, s.n / 4);
    any = any || s.present[k];
    if (!s.present[k])
      s.notices.push_back(fmt::format(
          "{}: only {} of {} rows stand beside a reference without a break: rows were lost, or the reference "
          "has too few frames a second to know the motion between them",
          kSensorName[k], rows, s.n));
  }
  return any;
}

/// Of how many rows, `merged` each already, the mean is taken: of more than `most`, which are needed.
Eigen::Index thinning_of(const Signals& s, Eigen::Index merged, double most) {
  const Eigen::Index rows = s.n / merged;
  const double step_s = s.dt_s * static_cast<double>(merged);
  return std::max<Eigen::Index>(
      1, static_cast<Eigen::Index>(std::min(static_cast<double>(rows) / most, kFastEnough_s / step_s)));
}

/// Lets go what twins show as well, and looks outside the catalogue.
void judge_and_discover(Signals& s, std::size_t twins, EngineResult& engine, Answer& answer) {
  if (twins > 0)
    for (auto& line : gate_by_twins(s, engine, twins)) answer.diagnosis.notices.push_back(std::move(line));
  discover(s, engine);
  settle_beside_laws(s, engine);
}

/// Whoever sees an effect of the whole clock best speaks first.
std::vector<Sensor> speaking_order(const EngineResult& engine) {
  std::vector<Sensor> order;
  for (const SystemEffect& e : engine.system)
    if (std::find(order.begin(), order.end(), e.lead) == order.end()) order.push_back(e.lead);
  for (const Sensor k : {kAcc, kGyr, kMag})
    if (std::find(order.begin(), order.end(), k) == order.end()) order.push_back(k);
  return order;
}

/// What is seen of means over seconds, where the reference hides less from row to row than from second to second.
struct SlowLook {
  std::optional<Signals> rows;  ///< nothing: they would show no more
  EngineResult engine;
};

SlowLook look_slowly(const Signals& s, const std::vector<std::string>& without, std::size_t twins, Answer& answer) {
  SlowLook slow{slow_rows(s), {}};
  if (!slow.rows) return slow;
  slow.engine = search_all(*slow.rows, without, {});
  judge_and_discover(*slow.rows, twins, slow.engine, answer);
  keep_what_is_slow(slow.engine);
  return slow;
}

/// Findings but the first `kept` by what they gain, and what is said of the whole.
void conclude(const Signals& s, std::size_t kept, Diagnosis& d) {
  std::stable_sort(d.findings.begin() + static_cast<std::ptrdiff_t>(kept), d.findings.end(),
                   [](const Finding& a, const Finding& b) { return a.held_out.gain_nats > b.held_out.gain_nats; });
  std::stable_partition(d.findings.begin(), d.findings.end(),
                        [](const Finding& f) { return !f.effect.ends_with("_quant"); });  // removes nothing: last
  for (const auto& n : s.notices) d.notices.push_back(n);
  std::sort(d.ranking.begin(), d.ranking.end(),
            [](const RankedHypothesis& a, const RankedHypothesis& b) { return a.gain_nats > b.gain_nats; });
  d.abstention_nats = charge(3, {}) + kLeastNet;
  d.verdict = verdict_of(d);
  d.summary = summarise(d);
}

}  // namespace

Answer diagnose_with_reference(const ReferencedRows& rows, const sim::SimulationConfig& simulation,
                               const Forensics& forensics, const std::vector<std::string>& without, std::size_t twins,
                               const std::function<void(double)>& progress, Answer answer) {
  const io::Recording& recording = rows.recording;
  const auto a_frame = static_cast<Eigen::Index>(rows.rows_a_frame);
  Result<Signals> made = make_signals(recording, simulation, masks(forensics), rows.log, a_frame);
  if (!made) return insufficient(made.error().message, std::move(answer));
  Signals& s = *made;
  if (s.duration_s() < kShortestRecording_s)
    return insufficient(fmt::format("{:.1f} s of recording are too short; record at least {:.0f} s", s.duration_s(),
                                    kShortestRecording_s),
                        std::move(answer));
  if (!enough_to_compare(s)) return insufficient(s.notices.back(), std::move(answer));
  for (std::size_t k = 0; k < kSensors; ++k)
    if (forensics.sensor[k].quantised) s.lattice_step[k] = forensics.sensor[k].lattice_step.maxCoeff();
  mute_lattice_at_rest(s);
  set_reference_on_time(s, simulation.reference);
  const std::vector<sim::EffectConfig> given = without_surplus(s, simulation.effects, answer);
  for (const std::string& id : subtract_effects(s, given))
    if (!shows_in_raw_values(id))
      answer.diagnosis.notices.push_back(
          fmt::format("effect {} of the simulation cannot be predicted from the recording; left in", id));
  compare_noise(s, answer);
  answer.diagnosis.findings = forensics.findings;
  answer.effects = forensics.effects;
  const Eigen::Index merged = s.exact_reference ? 1 : a_frame;
  Eigen::Index factor = thinning_of(s, merged, kMostSamples);
  find_lines_in_readings(s, merged * factor, without, answer);
  if (rows.log == nullptr) find_reference_error(s, recording, simulation, answer);
  // Between its frames a noisy reference knows nothing of its own: the rows of one frame are one.
  if (merged > 1) s = thinned(s, merged);
  find_frame(s, simulation, answer);
  take_out_wandering(s, answer);
  find_jitter(s, simulation, answer);
  if (s.jitter_sd_s > 0.0) factor = thinning_of(s, 1, kMostTimed);
  if (factor > 1) s = thinned(s, factor);
  EngineResult engine = search_all(s, without, progress);
  if (factor == 1 && find_jitter_beside(engine, s, simulation, answer)) engine = search_all(s, without, progress);
  judge_and_discover(s, twins, engine, answer);
  const SlowLook slow = look_slowly(s, without, twins, answer);
  const std::size_t kept = answer.diagnosis.findings.size();
  for (const Sensor k : speaking_order(engine)) {
    if (!engine.sensor[k]) continue;
    const bool slowly = slow.rows && is_seen_better(slow.engine, engine, k);
    if (slowly)
      answer.diagnosis.notices.push_back(
          fmt::format(kSeenSlowly, kSensorName[k], 3.0 * slow.rows->dt_s, slow.rows->dt_s));
    report_sensor(slowly ? *slow.rows : s, slowly ? slow.engine : engine, k, given, answer);
  }
  for (const Sensor k : {kAcc, kGyr, kMag})
    if (engine.sensor[k]) report_surplus_walk(*engine.sensor[k], s, given, answer);
  keep_what_was_right(simulation.effects, answer);
  leave_to_the_reference(s, answer);
  conclude(s, kept, answer.diagnosis);
  return answer;
}

}  // namespace stillpoint::diag
