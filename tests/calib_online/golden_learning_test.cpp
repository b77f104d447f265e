/// Every number of what is learnt, after each chapter of a sensor's life. What it has to be is asked elsewhere; here a
/// figure that is another one shows.
#include <gtest/gtest.h>

#include <sstream>

#include "calib_online/state_fields.h"
#include "tests/calib_online/session.h"
#include "tests/golden.h"

namespace stillpoint::calib {
namespace {

/// The whole state, and what is published of it; a line of numbers a field.
std::string numbers_of(const OnlineCalibrator& calibrator) {
  std::ostringstream out;
  out.precision(7);
  OnlineCalibrator::State state = calibrator.state();
  const auto line = [&out](const auto& values) {
    if constexpr (std::is_arithmetic_v<std::decay_t<decltype(values)>>)
      out << +values;
    else
      for (const auto& x : values) out << +x << ' ';
    out << '\n';
  };
  visit_state(state, [&line](const FieldOfState&, const auto& values) { line(values); });
  const CalibrationSnapshot& s = calibrator.snapshot();
  for (const TriadCalibration* t : {&s.acc, &s.gyr, &s.mag}) {
    line(t->matrix);
    line(t->bias);
    line(t->bias_per_K);
    line(t->bias_covariance);
    out << t->norm_sd << ' ' << t->windows << ' ' << static_cast<int>(t->status) << '\n';
  }
  return out.str();
}

constexpr test::GoldenTolerance kOfASum{1e-9, 2e-4};  // of thousands of readings, in another order

std::string life(const OnlineCalibratorParams& params, bool has_mag) {
  test::SensorTruth truth = test::consumer_sensor();
  truth.H_mag << 1.03, 0.01, 0.0, 0.01, 0.97, 0.02, 0.0, 0.02, 1.01;
  truth.b_mag = Vec3(12, -20, 8);
  truth.has_mag = has_mag;
  test::Session session(truth, 6, params);
  std::string text;
  const auto chapter = [&](int turns, unsigned seed) {
    session.turns(turns, seed);
    text += numbers_of(session.calibrator);
  };
  chapter(12, 1);
  session.source.temp_degC = 33.0;
  chapter(14, 2);
  session.source.temp_degC = 19.0;
  session.source.truth().b_gyr += Vec3(0.02, -0.01, 0.015);  // a drop
  chapter(10, 3);
  test::Motion train;
  train.force_mps2 = [](double) { return Vec3(1.0, 0.0, 0.0); };
  session.live(18.0, train);
  chapter(6, 4);
  session.source.truth().b_acc = Vec3(-0.6, 0.5, 0.4);  // another sensor
  session.source.truth().b_mag = Vec3(-30, 15, 22);
  chapter(16, 5);
  return text;
}

TEST(GoldenLearning, AllOfALife) { test::check_golden("learning", life({}, true), kOfASum); }

TEST(GoldenLearning, WithCellsAndWithoutAMagnetometer) {
  OnlineCalibratorParams params;
  params.temperature_model = "cells";
  test::check_golden("learning_cells", life(params, false), kOfASum);
}

}  // namespace
}  // namespace stillpoint::calib
