#include "diagnosis/no_reference/no_reference.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "diagnosis/finding_effect.h"
#include "diagnosis/forensics/forensics.h"
#include "diagnosis/no_reference/field.h"
#include "diagnosis/no_reference/findings.h"
#include "diagnosis/no_reference/lines_at_rest.h"
#include "diagnosis/no_reference/noisy_rail.h"
#include "diagnosis/no_reference/still.h"
#include "diagnosis/no_reference/trials.h"

namespace stillpoint::diag {
namespace {

using detail::bent;
using detail::Candidate;
using detail::open_laws;
using detail::SelfConsistency;
using detail::Trial;
using detail::WitnessedLaw;

constexpr int kMostFindings = 3;
constexpr double kCoarseOverNoise =
    3.0;  // noise dithers a finer lattice: its bias stays below a tenth of the noise (Widrow 1996)
constexpr double kLeastOfFirst = 0.02;  // smaller gains are the second order of the first finding
constexpr double kDriftOverLaw = 1.15;  // a free offset per rest must beat a law by this to take its place
constexpr double kAccelerates_mps2 = 0.02;
constexpr double kLeastShare = 0.5;   // a law that removes less of what is not noise is not the cause
constexpr double kForceMisfit = 1.6;  // whitened rms of the accelerometer's rests above this is more than noise

constexpr const char* kNoRest =
    "no window of rest: put the sensor down for 3 s between movements, in different attitudes";

/// What judges, in words.
std::string witnesses(const SelfConsistency& model) {
  return model.rest().empty() ? "gyroscope and magnetometer" : "gyroscope, magnetometer and rests";
}

void conclude(const SelfConsistency& model, const Forensics& raw, bool believable, Diagnosis& d) {
  const bool force_off = model.force_misfit() > kForceMisfit;
  d.notices.push_back(
      model.rest().empty()
          ? fmt::format(
                "gyroscope and magnetometer are judged by each other alone, the accelerometer by its raw values: "
                "{}, or record a reference orientation and position",
                kNoRest)
          : "accelerometer: without a reference it is witnessed at rest alone, by the attitude that the gyroscope "
            "carries from rest to rest; its dynamics and delay stay untested. Record rests of 3 s in at least twelve "
            "attitudes, or a reference orientation and position");
  const bool unknown =
      std::any_of(d.findings.begin(), d.findings.end(), [](const Finding& f) { return is_unknown(f); });
  if (!d.findings.empty()) {
    d.verdict = unknown ? Verdict::kUnexplained : Verdict::kExplained;
    std::vector<std::string> parts;
    for (const Finding& f : d.findings) parts.push_back(fmt::format("{} ({})", f.effect, fmt::join(f.channels, ", ")));
    d.summary = fmt::format("Missing physics: {}; found from {}, by each other, without a reference.",
                            fmt::join(parts, "; "), witnesses(model));
    if (!unknown && bent(model)) {
      d.verdict = Verdict::kPartlyExplained;
      d.summary += fmt::format(
          " Beyond it {} disagree by {:.1f} times their noise, by no law of the library or by a matrix too wrong to "
          "start from.",
          witnesses(model), std::sqrt(model.dispersion()));
    }
  } else if (bent(model)) {
    d.verdict = Verdict::kUnexplained;
    d.summary = fmt::format(
        "Something is there that no law of the library explains: {} disagree by {:.1f} times their noise. Record a "
        "reference orientation to decide.",
        witnesses(model), std::sqrt(model.dispersion()));
  } else if (force_off) {
    d.verdict = Verdict::kInsufficientData;
    d.summary = fmt::format(
        "Insufficient data for the accelerometer: its rests depart from gravity by {:.1f} times their noise, and "
        "without a reference the cause cannot be told. Gyroscope and magnetometer agree with the simulation.",
        model.force_misfit());
  } else if (!believable) {
    d.verdict = Verdict::kInsufficientData;
    d.summary = fmt::format(
        "Insufficient data: {} agree only with matrices that no sensor has, so something else is missing that this "
        "recording does not tell. Record more rests, or a reference orientation.",
        witnesses(model));
  } else if (!d.configuration.empty()) {
    d.verdict = Verdict::kWrongNumbers;
    d.summary = fmt::format("Wrong numbers, not missing physics: {} {}; found from {}, by each other.",
                            d.configuration.front().sensor, d.configuration.front().what, witnesses(model));
  } else {
    d.verdict = Verdict::kNoMismatch;
    d.summary = fmt::format(
        "No mismatch in what can be seen without a reference: {} agree with each other and with the simulation.",
        witnesses(model));
  }
  for (const auto& n : raw.notices) d.notices.push_back(n);
}

constexpr const char* kSpoiled =
    "the gyroscope's raw values are spoiled, and without a reference everything else is judged by it; repair that "
    "first";

/// Where the raw values are all that can be judged.
void judge_raw_only(const std::string& why, const Forensics& raw, Diagnosis& d) {
  d.verdict = d.findings.empty() ? Verdict::kInsufficientData : Verdict::kPartlyExplained;
  d.summary = d.findings.empty()
                  ? "Insufficient data: " + why
                  : fmt::format("Found {} in the raw values; for the rest: {}", d.findings.front().effect, why);
  d.notices.push_back(why);
  d.notices.insert(d.notices.end(), raw.notices.begin(), raw.notices.end());
}

/// Why nothing beyond the raw values can be judged; empty when it can.
std::string what_is_missing(const io::Recording& recording, const sim::SimulationConfig& simulation,
                            const Forensics& raw, std::size_t rests) {
  const auto* gyro = triad(simulation, kGyr);
  const bool coarse = gyro && raw.sensor[kGyr].quantised &&
                      raw.sensor[kGyr].lattice_step.maxCoeff() > kCoarseOverNoise * gyro->noise_sd;
  const bool faulty = std::any_of(raw.findings.begin(), raw.findings.end(), [](const Finding& f) {
    return f.effect.starts_with("gyr_") && !f.effect.ends_with("_quant");
  });
  if (faulty || coarse) return kSpoiled;
  if (!gyro || recording.gyr_radps.empty() || !simulation.accelerometer || recording.acc_mps2.empty())
    return "without a reference, gyroscope and accelerometer are both needed: record them or add a reference "
           "orientation";
  if (rests == 0 && (!simulation.magnetometer || recording.mag_uT.empty()))
    return fmt::format("{}, or record its magnetometer or a reference orientation", kNoRest);
  return {};
}

/// A slow offset that no law reaches, in the first round; true when one was stated. `best`: the score of the best of
/// all laws. Of gyroscope and magnetometer the one that explains more: the field's offset moves too where the gyroscope
/// turns it wrongly.
bool state_drift(const SelfConsistency& model, const sim::SimulationConfig& simulation, double best, Diagnosis& d) {
  std::pair<double, Sensor> most{-HUGE_VAL, kGyr};
  for (const Sensor s : {kGyr, kMag}) {
    const std::string id = fmt::format("{}_drift", kSensorName[s]);
    if (contains(simulation.effects, id)) continue;
    const double drift = detail::drift_score(model, s);
    if (s == kGyr && drift >= detail::kAbstain_nats && model.acceleration_at_rest_mps2() > kAccelerates_mps2)
      continue;  // then rests disagree without one
    d.ranking.push_back({id, drift});
    if (drift > most.first) most = {drift, s};
  }
  const auto [score, sensor] = most;
  if (score < detail::kAbstain_nats || score < kDriftOverLaw * best + detail::kAbstain_nats) return false;
  d.findings.push_back(detail::describe_drift(model, sensor, score));
  return true;
}

/// What is open in one round, by score before and after it was tried, and the best of it.
struct Round {
  std::vector<WitnessedLaw> laws;
  std::vector<Candidate> untried, ranking;
  Trial best;
};

Round look(const SelfConsistency& model, const sim::SimulationConfig& simulation,
           const std::vector<std::string>& without, const Diagnosis& d, double least_gain) {
  Round r;
  r.laws = open_laws(model, simulation, without);
  std::erase_if(r.laws, [&](const WitnessedLaw& law) { return contains(d.findings, law.id); });
  r.untried = r.ranking = detail::rank(model, r.laws);
  if (!r.ranking.empty() && r.ranking.front().fit.gain_nats >= least_gain)
    r.best = detail::best_of(model, simulation, without, r.ranking);
  return r;
}

void search(std::unique_ptr<SelfConsistency>& model, const sim::SimulationConfig& simulation,
            const std::vector<std::string>& without, Diagnosis& d) {
  double first_gain = 0.0;
  bool lost = false;
  for (int round = 0; round < kMostFindings; ++round) {
    Round r = look(*model, simulation, without, d, kLeastOfFirst * first_gain);
    if (r.best.model && bent(*model) && !lost) {
      auto plain = detail::put_back(r.best);
      lost = plain->misfit_nats() < model->misfit_nats() - detail::kAbstain_nats;
      if (lost) {
        model = std::move(plain);
        r = look(*model, simulation, without, d, kLeastOfFirst * first_gain);
      }
    }
    if (round == 0) {
      for (const auto& c : r.untried) d.ranking.push_back({c.law->id, c.score});
      const double best = r.untried.empty() ? 0.0 : std::max(0.0, r.untried.front().score);
      const bool left = !r.best.model || bent(*r.best.model);  // a law that leaves nothing needs no free offsets
      if (left && state_drift(*model, simulation, best, d)) return;
    }
    if (!r.best.model) return;
    const Candidate& c = r.best.candidate;
    const detail::Agreement& agreed = r.best.agreed();
    if (agreed.nats < detail::kAbstain_nats) return;
    Finding f = detail::describe(*r.best.model, c, agreed.sd, r.ranking);
    if (!(f.held_out.gain_nats > 1.0) || f.channels.empty()) return;
    if (f.held_out.removable_share_removed < kLeastShare && bent(*r.best.model)) {
      d.findings.push_back(detail::describe_unknown(*r.best.model, c.law->sensor, c));
      return;
    }
    first_gain = std::max(first_gain, c.fit.gain_nats);
    d.findings.push_back(std::move(f));
    r.best.model->accept(c.law->columns(c.grid_value));
    model = std::move(r.best.model);
  }
}

/// Rails that neither the raw values have told already nor the simulation has.
std::vector<Finding> open_rails(const io::Recording& recording, const sim::SimulationConfig& simulation,
                                const Forensics& raw, const std::vector<std::string>& without) {
  std::vector<Finding> rails = detail::find_noisy_rails(recording, simulation);
  std::erase_if(rails, [&](const Finding& rail) {
    return contains(simulation.effects, rail.effect) || contains(without, rail.effect) ||
           contains(raw.findings, rail.effect);
  });
  return rails;
}

/// A turntable stands at one rate as a rail does; what is cut off a turn is missing in the attitude after it. True
/// where the gyroscope's rail was stated.
bool state_rails(const SelfConsistency& model, std::vector<Finding> rails, Diagnosis& d) {
  bool gyroscope = false;
  for (Finding& rail : rails) {
    const bool of_gyroscope = rail.effect.starts_with(kSensorName[kGyr]);
    if (of_gyroscope && !bent(model)) continue;
    gyroscope |= of_gyroscope;
    d.findings.push_back(std::move(rail));
  }
  return gyroscope;
}

/// What is judged, as rests or as motion.
struct Asked {
  const io::Recording &recording, &without_lines;
  const sim::SimulationConfig& simulation;
  const Forensics &raw, &masked;
  const std::vector<std::string>& without;
};

struct Judged {
  std::unique_ptr<SelfConsistency> model;
  Diagnosis diagnosis;
};

Judged judge(const Asked& asked, const std::vector<detail::RestWindow>& rest, Diagnosis d) {
  auto model = std::make_unique<SelfConsistency>(asked.without_lines, asked.simulation, asked.masked, rest);
  model->settle();
  detail::take_out_given(*model, detail::witnessed_laws(*model, asked.simulation), asked.simulation.effects);
  model->keep_noise();
  const std::array<SelfConsistency::Series, 2> before{model->series(kGyr, {}, {}), model->series(kMag, {}, {})};
  if (state_rails(*model, open_rails(asked.recording, asked.simulation, asked.raw, asked.without), d)) {
    judge_raw_only(kSpoiled, asked.raw, d);
    return {std::move(model), std::move(d)};
  }
  search(model, asked.simulation, asked.without, d);
  std::sort(d.ranking.begin(), d.ranking.end(), [](const auto& a, const auto& b) { return a.gain_nats > b.gain_nats; });
  detail::fill_channels(*model, before, d);
  bool believable = true;
  if (!bent(*model)) {  // a bent attitude bends them too
    auto numbers = model->wrong_numbers();
    believable = numbers.has_value();
    if (numbers) d.configuration = std::move(*numbers);
  }
  conclude(*model, asked.raw, believable, d);
  return {std::move(model), std::move(d)};
}

}  // namespace

Diagnosis diagnose_without_reference(const io::Recording& recording, const sim::SimulationConfig& simulation,
                                     const std::vector<std::string>& without) {
  Diagnosis d;
  const Forensics raw = examine_raw_values(recording, simulation);
  if (detail::lies_still(recording)) {
    d = detail::diagnose_still(recording, simulation, without);
    if (d.findings.empty() && !raw.findings.empty()) {
      d.verdict = Verdict::kExplained;
      d.summary = fmt::format(
          "Found {} in the raw values; beyond it no mismatch in what a recording at rest in one "
          "attitude can show.",
          raw.findings.front().effect);
    }
    d.findings.insert(d.findings.end(), raw.findings.begin(), raw.findings.end());
    d.notices.insert(d.notices.end(), raw.notices.begin(), raw.notices.end());
    return d;
  }
  d.findings = raw.findings;
  d.abstention_nats = detail::kAbstain_nats;
  auto rest = detail::find_rest(recording, simulation);
  if (detail::sways(recording, rest)) {
    rest.clear();
    d.notices.push_back("what seems to be rest is none: gravity leans as the gyroscope turns, as aboard a ship");
  }
  if (const std::string why = what_is_missing(recording, simulation, raw, rest.size()); !why.empty()) {
    judge_raw_only(why, raw, d);
    return d;
  }
  const detail::LinesAtRest lines = detail::find_lines_at_rest(recording, simulation, rest, without);
  d.findings.insert(d.findings.end(), lines.findings.begin(), lines.findings.end());
  d.notices.insert(d.notices.end(), lines.notices.begin(), lines.notices.end());
  const detail::DisturbedField disturbed = detail::find_disturbed_field(lines.without, simulation, raw, rest);
  d.findings.insert(d.findings.end(), disturbed.findings.begin(), disturbed.findings.end());
  const Asked asked{recording, lines.without, simulation, raw, disturbed.masked, without};
  Judged judged = judge(asked, rest, d);
  if (bent(*judged.model) && !rest.empty() && what_is_missing(recording, simulation, raw, 0).empty()) {
    d.notices.push_back(
        "what seems to be rest contradicts itself, as in a vehicle that accelerates: not taken for rest");
    Judged in_motion = judge(asked, {}, d);
    if (!bent(*in_motion.model)) return in_motion.diagnosis;
  }
  return judged.diagnosis;
}

}  // namespace stillpoint::diag
