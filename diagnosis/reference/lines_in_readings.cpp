#include "diagnosis/reference/lines_in_readings.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/reference/finding_of_law.h"
#include "diagnosis/reference/given_effects.h"
#include "diagnosis/reference/judge.h"
#include "diagnosis/reference/lines.h"
#include "diagnosis/reference/nameless.h"
#include "diagnosis/reference/peaks.h"
#include "diagnosis/reference/response.h"

namespace stillpoint::diag {
namespace {

constexpr std::size_t kMostLines = 2;   // of one sensor
constexpr double kOfHalfRate = 0.8;     // of merged rows: what is slower they show as well
constexpr double kBeyondMotion = 1.25;  // times its band: where the motion ends that the sensor sees

/// From which frequency on the readings of a sensor know more than the residuals that are searched later.
std::optional<double> lowest_Hz(const Signals& s, Sensor k, Eigen::Index rows_merged) {
  if (vector_is_reading(s, k)) return std::max(kBeyondMotion * s.band_hz[k], kMotionBand_Hz);
  if (rows_merged > 1) return kOfHalfRate * 0.5 / (s.dt_s * static_cast<double>(rows_merged));
  return std::nullopt;
}

/// What a sensor shows where the reference says nothing: its own readings, without the motion.
Series3 beyond_motion(const Signals& s, Sensor k) {
  const Series3 reading = s.residual[k] + s.predicted[k];  // without what the simulation has already
  return reading - apply_response(reading, s.rows, low_pass(s.band_hz[k]));
}

SensorSearch lines_of(const Signals& s, Sensor k, double lowest, const std::vector<std::string>& without) {
  SensorSearch search;
  search.sensor = k;
  search.target = make_target(s, k);
  search.t_s = s.t_s;
  if (vector_is_reading(s, k)) search.target.residual = beyond_motion(s, k);
  for (std::size_t tried = 0; tried < kMostLines; ++tried) {  // a second one may undo the first
    auto line = line_beyond(s, search, lowest);
    if (!line || std::find(without.begin(), without.end(), line->id) != without.end()) return search;
    if (is_a_harmonic(s.reading[k], s.dt_s, line->shape)) return search;
    Judge(search).weigh(*line);
    if (line->net_nats < kLeastNetBeside) return search;
    SensorSearch with = search;
    accept(with, std::move(*line));
    const HeldOut h = held_out_by_regime(with, {with.found.size() - 1});
    if (!predicts(h) || fails_elsewhere(h, with.found.back().id)) return search;
    search = std::move(with);
  }
  return search;
}

void tell(Signals& s, const SensorSearch& search, const Finished& finished, Answer& answer) {
  for (std::size_t i = 0; i < search.found.size(); ++i) {
    const Found& f = search.found[i];
    if (f.kind == Kind::kConfiguration) {
      s.shaken[search.sensor] = true;
      answer.diagnosis.notices.push_back(vibration_notice(search.sensor, f));
      continue;
    }
    answer.diagnosis.findings.push_back(finding_from(s, search, i, finished, held_out_by_regime(search, {i})));
    const auto count = static_cast<Eigen::Index>(f.columns.size());
    if (const auto e = to_effect(f, finished.values.segment(first_column(search, i), count), s))
      answer.effects.push_back(*e);
  }
}

}  // namespace

void find_lines_in_readings(Signals& s, Eigen::Index rows_merged, const std::vector<std::string>& without,
                            Answer& answer) {
  for (const Sensor k : {kAcc, kGyr, kMag}) {
    if (!s.compared(k)) continue;
    const auto lowest = lowest_Hz(s, k, rows_merged);
    if (!lowest) continue;
    const SensorSearch search = lines_of(s, k, *lowest, without);
    if (search.found.empty()) continue;
    const Finished finished = finish(search);
    tell(s, search, finished, answer);
    without_noise_of(k, answer.diagnosis);
    s.residual[k] -= contribution_of(search.explained(), finished.values, s.n);
  }
}

}  // namespace stillpoint::diag
