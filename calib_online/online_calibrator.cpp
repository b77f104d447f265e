#include "calib_online/online_calibrator.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "calib_online/state_fields.h"
#include "core/units.h"

namespace stillpoint::calib {
namespace {

TemperatureModel model_of(const std::string& name) {
  return name == "none"    ? TemperatureModel::kNone
         : name == "cells" ? TemperatureModel::kCells
                           : TemperatureModel::kPolynomial;
}

}  // namespace

std::string check(const OnlineCalibratorParams& params) {
  const std::string& model = params.temperature_model;
  if (model == "none" || model == "cells" || model == "polynomial") return {};
  return "temperature_model is '" + model + "'; it must be none, cells or polynomial";
}

OnlineCalibrator::OnlineCalibrator(const Params& params, const CalibrationSnapshot& factory)
    : params_(params),
      factory_(factory),
      snapshot_(factory),
      acc_({params.accelerometer, model_of(params.temperature_model), params.temperature_cells, params.gravity_mps2},
           factory.acc),
      gyr_(params.gyroscope, factory.gyr),
      gyr_matrix_(params.gyro_matrix, factory.gyr, params.gyroscope.bias_sd_radps, params.gravity_mps2),
      mag_(params.magnetometer, factory.mag) {
  gyr_matrix_.publish(snapshot_.gyr);
  sound_ = {factory.acc.status, factory.gyr.status, factory.mag.status};
}

OnlineCalibrator::State OnlineCalibrator::state() const noexcept {
  State out;
  out.bytes = sizeof(State);
  out.acc = acc_.state();
  out.gyr = gyr_.state();
  out.gyr_matrix = gyr_matrix_.state();
  out.mag = mag_.state();
  out.temperatures = temperatures_;
  out.gyr_matrix_sd = gyr_matrix_.sd();
  out.snapshot_version = snapshot_.version;
  out.t_ns = t_ns_;
  return out;
}

bool OnlineCalibrator::restore(std::span<const std::byte> bytes) noexcept {
  State state;
  if (bytes.size() != sizeof state) return false;
  std::memcpy(&state, bytes.data(), sizeof state);
  return restore(state);
}

bool OnlineCalibrator::restore(const State& state) noexcept {
  if (state.version != State::kVersion || state.bytes != sizeof(State)) return false;
  if (!fault_of(state).empty()) return false;
  acc_.restore(state.acc);
  gyr_.restore(state.gyr);
  gyr_matrix_.restore(state.gyr_matrix);
  mag_.restore(state.mag);
  temperatures_ = state.temperatures;
  t_ns_ = state.t_ns;
  snapshot_.version = state.snapshot_version;
  snapshot_.t_ns = state.t_ns;
  const double temp_degC =
      temperatures_.known != 0 ? 0.5 * (temperatures_.min_degC + temperatures_.max_degC) : factory_.acc.temp_ref_degC;
  if (acc_.windows() > 0) acc_.publish(temp_degC, temperatures_, snapshot_.acc);
  if (gyr_.windows() > 0) gyr_.publish(temp_degC, temperatures_, snapshot_.gyr);
  gyr_matrix_.publish(snapshot_.gyr);
  if (mag_.turns() > 0) mag_.publish(snapshot_.mag);
  stuck_ = clipped_ = 0;
  sound_ = {snapshot_.acc.status, snapshot_.gyr.status, snapshot_.mag.status};
  return true;
}

bool OnlineCalibrator::absorb(const Window& window) noexcept {
  snapshot_.acc.status = sound_[0];
  snapshot_.gyr.status = sound_[1];
  snapshot_.mag.status = sound_[2];
  const bool faults_changed = window.stuck != stuck_ || window.clipped != clipped_;
  stuck_ = window.stuck;
  clipped_ = window.clipped;
  const bool changed = ((window.has & (kAcc | kGyr | kMag)) != 0 && learn(window)) || faults_changed;
  for (std::size_t k = 0; k < 3; ++k) name_fault(k);
  if (changed) {
    ++snapshot_.version;
    snapshot_.t_ns = window.t_end_ns;
  }
  return changed;
}

bool OnlineCalibrator::absorb(const FieldTurn& turn) noexcept {
  if (!mag_.absorb(turn, gyr_matrix_.sd(), snapshot_.gyr.norm_sd)) return false;
  mag_.publish(snapshot_.mag);
  name_fault(2);
  ++snapshot_.version;
  snapshot_.t_ns = turn.t_end_ns;
  return true;
}

void OnlineCalibrator::take_field(const MagLearner& field) noexcept {
  mag_ = field;
  mag_.publish(snapshot_.mag);
  name_fault(2);
  ++snapshot_.version;
}

bool OnlineCalibrator::absorb(std::span<KnownTurn> turns) noexcept {
  if (!gyr_matrix_.absorb(turns) || !gyr_matrix_.publish(snapshot_.gyr)) return false;
  ++snapshot_.version;
  return true;
}

/// What a triad (acc, gyr, mag) that is stuck or clipped has learnt stays; its status says that it cannot be relied on
/// now.
void OnlineCalibrator::name_fault(std::size_t triad) noexcept {
  const std::array<TriadCalibration*, 3> triads{&snapshot_.acc, &snapshot_.gyr, &snapshot_.mag};
  CalibrationStatus& status = triads[triad]->status;
  sound_[triad] = status;
  if ((clipped_ & kTriadBits[triad]) != 0) status = CalibrationStatus::kClipped;
  if ((stuck_ & kTriadBits[triad]) != 0) status = CalibrationStatus::kStuck;
}

void OnlineCalibrator::predict(std::int64_t t_ns) noexcept {
  // A clock that starts again (a new run on a persisted state) says nothing of the time between.
  const double dt_s = t_ns_ > 0 && t_ns > t_ns_ ? in_seconds(t_ns - t_ns_) : 0.0;
  t_ns_ = t_ns;
  acc_.predict(dt_s);
  gyr_.predict(dt_s);
}

/// Of up in the body, rad: before the accelerometer is learnt, what its factory calibration leaves.
double OnlineCalibrator::direction_sd() const noexcept {
  const double at_first = params_.accelerometer.bias_sd_mps2 / params_.gravity_mps2;
  const double norm_sd = snapshot_.acc.norm_sd;
  return norm_sd > 0.0 ? std::min(at_first, norm_sd / params_.gravity_mps2) : at_first;
}

bool OnlineCalibrator::learn(const Window& window) noexcept {
  predict(window.t_end_ns);
  const double temp_degC = (window.has & kTemp) != 0 ? window.temp_degC : factory_.acc.temp_ref_degC;
  temperatures_.see(temp_degC);
  bool acc = false, gyr = false;
  if ((window.has & kAcc) != 0) acc = acc_.absorb(window);
  if (acc) acc_.publish(window.temp_degC, temperatures_, snapshot_.acc);
  if (window.refusal == Refusal::kTurning) gyr = gyr_.turn_seen();
  const bool replaced_before = gyr_.replaced();
  if ((window.has & kGyr) != 0) gyr = gyr_.absorb(window, direction_sd()) || gyr;
  if (gyr_.replaced() && !replaced_before) gyr_matrix_.sensor_replaced();
  if (gyr) gyr_.publish(window.temp_degC, temperatures_, snapshot_.gyr);
  const bool matrix = gyr_matrix_.absorb(window, snapshot_, acc_.pushed_var()) && gyr_matrix_.publish(snapshot_.gyr);
  return acc || gyr || matrix;
}

}  // namespace stillpoint::calib
