#include "diagnosis/foreign/foreign.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "diagnosis/finding_effect.h"
#include "diagnosis/reference/given_effects.h"
#include "diagnosis/reference/with_reference.h"
#include "diagnosis/sanity/comparison.h"
#include "diagnosis/sanity/rows_with_reference.h"
#include "diagnosis/sanity/sensor_rows.h"
#include "simulation/effect_catalogue.h"
#include "simulation/triad.h"

namespace stillpoint::diag {
namespace {

/// The world's field in what the log says its magnetometer reads, beside an offset of the body.
Vec3 field_of(const AlignedLog& log) {
  Eigen::Matrix<double, 6, 6> G = Eigen::Matrix<double, 6, 6>::Identity() * 1e-6;
  Eigen::Matrix<double, 6, 1> g = Eigen::Matrix<double, 6, 1>::Zero();
  for (std::size_t i = 0; i < log.reference.size(); ++i) {
    const Eigen::Vector4d& q = log.reference.ref_q_world_body[i];
    const Vec3 reads = log.reading[kMag].row(static_cast<Eigen::Index>(i));
    if (!q.allFinite() || !reads.allFinite() || log.unread[kMag][i]) continue;
    Eigen::Matrix<double, 3, 6> row;
    row << detail::as_expected(q).conjugate().toRotationMatrix(), Mat3::Identity();
    G += row.transpose() * row;
    g += row.transpose() * reads;
  }
  return G.ldlt().solve(g).head<3>();
}

/// A simulation that changes nothing: what the log says is what the sensor should read. The noise is that of both.
sim::SimulationConfig nothing_added(const AlignedLog& log, const io::Recording& recording) {
  sim::SimulationConfig out;
  out.rate_hz = 1.0 / recording.median_step_s();
  const std::array<const std::vector<Vec3>*, kSensors> columns{&recording.acc_mps2, &recording.gyr_radps,
                                                               &recording.mag_uT};
  const std::array<std::optional<sim::TriadConfig>*, kSensors> triads{&out.accelerometer, &out.gyroscope,
                                                                      &out.magnetometer};
  for (std::size_t k = 0; k < kSensors; ++k)
    if (!columns[k]->empty() && log.reading[k].rows() > 0)
      *triads[k] = sim::TriadConfig{.noise_sd = std::hypot(log.own_noise_sd[k], log.noise_sd[k])};
  if (log.reading[kMag].rows() > 0) out.field_world_uT = field_of(log);
  return out;
}

bool is_hold(const sim::EffectConfig& e) { return e.id.ends_with("_hold"); }

/// What the readings of the log show as those of the recording do - rails, steps, a dead zone -, which is no difference
/// of the two. A hold counts rows: it is the same at the same rate only.
std::vector<sim::EffectConfig> shown_by_both(const io::Recording& log, const io::Recording& recording,
                                             const sim::SimulationConfig& simulation) {
  constexpr double kSameRate = 0.01;
  const bool same_rate = std::abs(log.median_step_s() / recording.median_step_s() - 1.0) < kSameRate;
  const std::vector<sim::EffectConfig> ours = examine_raw_values(recording, simulation).effects;
  std::vector<sim::EffectConfig> out = ours.empty() ? ours : examine_raw_values(log, simulation).effects;
  std::erase_if(out, [&](const sim::EffectConfig& e) {
    const auto same = [&e](const sim::EffectConfig& other) { return same_numbers(e, other); };
    return (is_hold(e) && !same_rate) || std::none_of(ours.begin(), ours.end(), same);
  });
  return out;
}

std::vector<Vec3> column_of(const Series3& x, const Mask& unread) {
  std::vector<Vec3> out;
  for (Eigen::Index i = 0; i < x.rows(); ++i)
    out.push_back(unread[static_cast<std::size_t>(i)] ? Vec3::Constant(io::kMissing) : Vec3(x.row(i)));
  return out;
}

/// What acts on the finished reading; clipped before a filter, it is no rail.
bool acts_on_reading(const sim::EffectConfig& e) {
  if (sim::find_effect(e.id) == nullptr) return false;
  const auto hidden = e.parameters.find("hidden");
  if (e.id.ends_with("_sat")) return hidden == e.parameters.end() || hidden->second.front() == 0.0;
  return e.id.ends_with("_quant") || e.id.ends_with("_deadzone") || is_hold(e);
}

/// What the sensor reads of the signal, row by row, by the simulator's own digital half. A stale hold is none of it:
/// that repeats where the recording does, as no number says at which row it begins.
Series3 readings_of_signal(const Signals& s, Sensor k, const Series3& signal, const Answer& answer) {
  sim::SimulationConfig config;
  config.rate_hz = 1.0 / s.dt_s;
  for (const sim::EffectConfig& e : answer.effects)
    if (acts_on_reading(e) && !is_hold(e)) config.effects.push_back(e);
  sim::TriadConfig numbers;
  if (const auto& right = answer.numbers[k]) numbers.bias = right->bias, numbers.matrix = right->matrix;
  sim::Triad triad(static_cast<sim::Sensor>(k), config, numbers, 0);
  Series3 out(s.n, 3);
  for (Eigen::Index i = 0; i < s.n; ++i) out.row(i) = triad.reading(signal.row(i).transpose(), s.t_s[i]).transpose();
  return out;
}

void hold_as(const std::vector<Vec3>& recorded, Series3& x) {
  for (std::size_t i = 1; i < recorded.size(); ++i)
    for (Eigen::Index axis = 0; axis < 3; ++axis)
      if (const auto row = static_cast<Eigen::Index>(i); recorded[i][axis] == recorded[i - 1][axis])
        x(row, axis) = x(row - 1, axis);
}

/// Findings without an entry, and entries that are no function of what is recorded.
std::vector<std::string> not_improved(const Answer& answer, const std::vector<std::string>& not_predicted) {
  std::vector<std::string> out;
  for (const Finding& f : answer.diagnosis.findings)
    if (std::none_of(answer.effects.begin(), answer.effects.end(), [&f](const auto& e) { return is_entry_of(e, f); }))
      out.push_back(fmt::format("{} is not in the improved log: no law of it is known", f.effect));
  for (const std::string& id : not_predicted)
    out.push_back(fmt::format("{} is not in the improved log: what is recorded does not say when and how much", id));
  return out;
}

void improve(const AlignedLog& log, const Signals& before, LogAnswer& out) {
  const Answer& answer = out.answer;
  Signals after = before;
  std::vector<std::string> not_predicted = subtract_effects(after, answer.effects);
  std::erase_if(not_predicted, [&answer](const std::string& id) {
    return std::any_of(answer.effects.begin(), answer.effects.end(),
                       [&id](const auto& e) { return e.id == id && acts_on_reading(e); });
  });
  out.not_improved = not_improved(answer, not_predicted);
  io::Recording& improved = out.improved = log.reference;
  const std::array<std::vector<Vec3>*, kSensors> columns{&improved.acc_mps2, &improved.gyr_radps, &improved.mag_uT};
  for (const Sensor k : {kAcc, kGyr, kMag}) {
    const std::vector<Vec3> recorded = std::exchange(*columns[k], {});
    if (!before.present[k] || before.residual[k].rows() == 0) continue;
    const Series3 signal = before.predicted[k] + before.residual[k] - after.residual[k];
    Series3 reads = readings_of_signal(before, k, signal, answer);
    if (contains(answer.effects, std::string(kSensorName[k]) + "_hold")) hold_as(recorded, reads);
    *columns[k] = column_of(reads, log.unread[k]);
  }
}

}  // namespace

Result<LogAnswer> diagnose_log(const io::Recording& log, const io::Recording& given,
                               const std::vector<std::string>& without, const std::function<void(double)>& progress) {
  std::vector<std::string> notices;
  const auto on_rows = readings_on_rows(given, notices);
  RowsWithReference with_frames;
  if (!given.ref_q_world_body.empty()) with_frames = rows_with_reference(on_rows ? *on_rows : given, notices);
  const io::Recording& recording = with_frames.changed ? *with_frames.changed : on_rows ? *on_rows : given;
  auto aligned = align(log, recording);
  if (!aligned) return tl::unexpected(aligned.error());
  LogAnswer out;
  sim::SimulationConfig simulation = nothing_added(*aligned, recording);
  simulation.effects = shown_by_both(log, recording, simulation);
  const Forensics forensics = examine_raw_values(recording, simulation);
  auto& told = out.answer.diagnosis.notices;
  const auto tell = [&told](const std::vector<std::string>& list) {
    told.insert(told.end(), list.begin(), list.end());
  };
  tell(notices), tell(aligned->notices), tell(forensics.notices);
  out.answer = diagnose_with_reference({aligned->reference, with_frames.rows_a_frame, &*aligned}, simulation, forensics,
                                       without, 0, progress, std::move(out.answer));
  const Result<Signals> signals = make_signals(aligned->reference, simulation, {}, &*aligned, with_frames.rows_a_frame);
  if (!signals) return tl::unexpected(signals.error());
  improve(*aligned, *signals, out);
  return out;
}

}  // namespace stillpoint::diag
