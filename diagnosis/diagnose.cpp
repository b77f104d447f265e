#include "diagnosis/diagnose.h"

#include <fmt/format.h>

#include <algorithm>

#include "diagnosis/finding_effect.h"
#include "diagnosis/forensics/forensics.h"
#include "diagnosis/no_reference/no_reference.h"
#include "diagnosis/reference/with_reference.h"
#include "diagnosis/sanity/rows_with_reference.h"
#include "diagnosis/sanity/sanity.h"
#include "diagnosis/sanity/sensor_rows.h"
#include "diagnosis/trajectory/trajectory.h"

namespace stillpoint::diag {
namespace {

/// What was set aside is no match: the verdict says so, and the summary begins with it.
void tell_what_was_set_aside(const Sanity& sanity, const sim::SimulationConfig& given, Diagnosis& d) {
  std::string absent;
  for (const Sensor s : {kAcc, kGyr, kMag}) {
    if (triad(given, s) == nullptr || !sanity.unusable[s]) continue;
    absent += fmt::format("{}{}", absent.empty() ? "" : ", ", kSensorName[s]);
  }
  if (!sanity.mistakes.empty()) {
    if (d.verdict == Verdict::kNoMismatch) d.verdict = Verdict::kInsufficientData;
    const std::size_t more = sanity.mistakes.size() - 1;
    d.summary = fmt::format("Input that cannot be right: {}{}. Of the rest: {}", sanity.mistakes.front(),
                            more == 0 ? "" : fmt::format(" (and {} more, see the notices)", more), d.summary);
  } else if (!absent.empty() && d.verdict != Verdict::kInsufficientData) {
    d.summary += fmt::format(" Not recorded, so not compared: {}.", absent);
  }
}

/// Biases and matrices that are told go into what `--improved` holds.
void set_right(const ConfigurationFault& fault, const sim::SimulationConfig& simulation, Answer& answer) {
  const auto axis = [](char c) { return static_cast<Eigen::Index>(c - 'x'); };
  for (const Sensor s : {kAcc, kGyr, kMag}) {
    if (fault.sensor != kSensorName[s] || fault.values.empty()) continue;
    auto& numbers = answer.numbers[s];
    if (!numbers) numbers = *triad(simulation, s);
    for (const Parameter& p : fault.values) {
      if (p.name.starts_with("bias_"))
        numbers->bias[axis(p.name.back())] = p.value;
      else
        numbers->matrix(axis(p.name[p.name.size() - 2]), axis(p.name.back())) = p.value;
    }
  }
}

Answer without_reference(const io::Recording& recording, const sim::SimulationConfig& simulation,
                         const std::vector<std::string>& without, Answer answer) {
  std::vector<std::string> notices = std::move(answer.diagnosis.notices);
  answer.diagnosis = diagnose_without_reference(recording, simulation, without);
  auto& own = answer.diagnosis.notices;
  own.insert(own.begin(), notices.begin(), notices.end());
  answer.effects = examine_raw_values(recording, simulation).effects;
  for (const Finding& f : answer.diagnosis.findings)
    if (auto e = effect_of(f); e && !contains(answer.effects, e->id)) answer.effects.push_back(std::move(*e));
  for (const ConfigurationFault& fault : answer.diagnosis.configuration) set_right(fault, simulation, answer);
  return answer;
}

}  // namespace

Answer insufficient(std::string why, Answer answer) {
  answer.diagnosis.verdict = Verdict::kInsufficientData;
  answer.diagnosis.summary = "Cannot decide: " + why;
  auto& notices = answer.diagnosis.notices;
  if (std::find(notices.begin(), notices.end(), why) == notices.end()) notices.push_back(std::move(why));
  return answer;
}

Answer diagnose(const io::Recording& given_recording, const sim::SimulationConfig& given,
                const std::vector<std::string>& without, std::size_t twins,
                const std::function<void(double)>& progress) {
  sim::SimulationConfig simulation = given;
  Answer answer;
  auto& notices = answer.diagnosis.notices;
  const auto on_rows = readings_on_rows(given_recording, notices);
  const io::Recording& recording = on_rows ? *on_rows : given_recording;
  RowsWithReference with_frames;
  if (!recording.ref_q_world_body.empty()) with_frames = rows_with_reference(recording, notices);
  auto& even = with_frames.changed;
  const Sanity sanity = check_input(even ? *even : recording, simulation);
  notices.insert(notices.end(), sanity.notices.begin(), sanity.notices.end());
  if (sanity.nothing_usable)
    return insufficient(sanity.mistakes.empty() ? "nothing in the recording can be used" : sanity.mistakes.front(),
                        std::move(answer));
  if (sanity.unusable[kAcc]) simulation.accelerometer.reset();
  if (sanity.unusable[kGyr]) simulation.gyroscope.reset();
  if (sanity.unusable[kMag]) simulation.magnetometer.reset();
  const auto learnt = examine(calibrate_along(recording, simulation), !recording.temp_degC.empty());
  notices.insert(notices.end(), learnt.begin(), learnt.end());
  if (recording.ref_q_world_body.empty() || sanity.reference_unusable) {
    answer = without_reference(recording, simulation, without, std::move(answer));
  } else {
    if (sanity.position_unusable && !even) even = recording;
    if (sanity.position_unusable) even->ref_position_m.clear();
    const io::Recording& rows = even ? *even : recording;
    const Forensics forensics = examine_raw_values(rows, simulation);
    notices.insert(notices.end(), forensics.notices.begin(), forensics.notices.end());
    answer = diagnose_with_reference({rows, with_frames.rows_a_frame}, simulation, forensics, without, twins, progress,
                                     std::move(answer));
  }
  tell_what_was_set_aside(sanity, given, answer.diagnosis);
  return answer;
}

}  // namespace stillpoint::diag
