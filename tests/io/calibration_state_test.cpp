/// What was learnt as text: it comes back to the last digit, and what cannot be is named and left out alone.
#include "io/calibration_state.h"

#include <gmock/gmock.h>

#include <random>

#include "calib_online/state_fields.h"
#include "core/units.h"

namespace stillpoint::io {
namespace {

using ::testing::HasSubstr;

/// Rest in many attitudes, as windows.
void teach(calib::OnlineCalibrator& calibrator) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  for (int k = 0; k < 60; ++k) {
    calib::Window w;
    w.t_end_ns = (k + 1) * 10'000'000'000LL;
    w.has = kAcc | kGyr | kTemp;
    w.temp_degC = 20.0 + 0.1 * k;
    const Vec3 up = Vec3(normal(random), normal(random), normal(random)).normalized();
    w.acc_mps2 = array(Vec3(kStandardGravity_mps2 * up + Vec3(0.1, -0.2, 0.05)));
    w.acc_cov = array(Mat3(1e-6 * Mat3::Identity()));
    w.gyr_radps = {0.01, -0.006, 0.004};
    w.gyr_cov = array(Mat3(1e-9 * Mat3::Identity()));
    w.turn_cov = array(Mat3(1e-8 * Mat3::Identity() + 3e-6 * up * up.transpose()));
    calibrator.absorb(w);
  }
}

calib::OnlineCalibrator taught(const CalibrationSnapshot& factory = {}) {
  calib::OnlineCalibrator calibrator({}, factory);
  teach(calibrator);
  return calibrator;
}

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  const auto at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return text.replace(at, what.size(), by);
}

/// The first number of a line is another one.
std::string with_first_number(const std::string& text, const std::string& name, const std::string& number) {
  const auto line = text.find('\n' + name + ' ') + 1;
  const auto unit = text.find(' ', line) + 1, first = text.find(' ', unit) + 1;
  return text.substr(0, first) + number + text.substr(text.find_first_of(" \n", first));
}

TEST(CalibrationState, ComesBackToTheLastDigit) {
  const auto before = taught();
  calib::OnlineCalibrator after({}, {});
  const auto remarks = restore_calibration(calibration_text(before), after);
  ASSERT_TRUE(remarks.has_value()) << remarks.error().message;
  EXPECT_TRUE(remarks->empty());
  EXPECT_EQ(calibration_text(after), calibration_text(before));
  EXPECT_EQ(after.snapshot().version, before.snapshot().version);
  EXPECT_GT(after.snapshot().acc.windows, 50U);
}

TEST(CalibrationState, IsReadableOneFieldALineWithUnits) {
  const std::string text = calibration_text(taught());
  EXPECT_THAT(text, ::testing::StartsWith("stillpoint-calibration 5\nfingerprint "));
  EXPECT_THAT(text, HasSubstr("\ngyr.bias rad/s 0.0"));
  EXPECT_THAT(text, HasSubstr("\nacc.windows - "));
}

TEST(CalibrationState, AFieldThatCannotBeCostsItsSensorOnly) {
  const auto before = taught();
  const std::string text = calibration_text(before);
  for (const char* bad : {"nan", "inf", "1e30", "word", "-1e9"}) {
    calib::OnlineCalibrator after({}, {});
    const auto remarks = restore_calibration(with_first_number(text, "gyr.bias", bad), after);
    ASSERT_TRUE(remarks.has_value()) << bad;
    ASSERT_EQ(remarks->size(), 1U) << bad;
    EXPECT_THAT(remarks->front(), HasSubstr("gyr.bias")) << bad;
    EXPECT_THAT(remarks->front(), HasSubstr("the gyroscope's bias is learnt anew"));
    EXPECT_EQ(after.snapshot().gyr.windows, 0U);
    EXPECT_EQ(after.snapshot().acc.windows, before.snapshot().acc.windows) << bad;
  }
  calib::OnlineCalibrator after({}, {});
  const auto remarks = restore_calibration(with_first_number(text, "acc.covariance", "-0.5"), after);
  ASSERT_TRUE(remarks.has_value());
  EXPECT_THAT(remarks->front(), HasSubstr("acc.covariance: is no covariance"));
}

TEST(CalibrationState, AnotherFactoryBiasOfTheGyroscopeIsConverted) {
  const auto before = taught();
  CalibrationSnapshot factory;
  factory.gyr.bias = {0.05, 0.0, -0.02};
  calib::OnlineCalibrator after({}, factory);
  const auto remarks = restore_calibration(calibration_text(before), after);
  ASSERT_TRUE(remarks.has_value());
  ASSERT_EQ(remarks->size(), 1U);
  EXPECT_THAT(remarks->front(), HasSubstr("converted"));
  calib::OnlineCalibrator same({}, {});
  ASSERT_TRUE(restore_calibration(calibration_text(before), same).has_value());
  EXPECT_LT((after.snapshot().gyr.bias_at(23.0) - same.snapshot().gyr.bias_at(23.0)).norm(), 1e-12);
}

TEST(CalibrationState, AnotherFactoryAccelerometerOrModelIsSetAsideWithAWord) {
  const std::string text = calibration_text(taught());
  CalibrationSnapshot factory;
  factory.acc.bias[0] = 0.4;
  calib::OnlineCalibrator another({}, factory);
  auto remarks = restore_calibration(text, another);
  ASSERT_TRUE(remarks.has_value());
  EXPECT_THAT(remarks->front(), HasSubstr("sensor.acc: another bias"));
  EXPECT_EQ(another.snapshot().acc.windows, 0U);
  EXPECT_GT(another.snapshot().gyr.windows, 0U);

  calib::OnlineCalibratorParams cells;
  cells.temperature_model = "cells";
  calib::OnlineCalibrator by_cells(cells, {});
  remarks = restore_calibration(text, by_cells);
  ASSERT_TRUE(remarks.has_value());
  EXPECT_THAT(remarks->front(), HasSubstr("temperature_model was 'polynomial' and is 'cells'"));
}

TEST(CalibrationState, OfAnotherVersionIsRefusedAndNothingChanges) {
  auto calibrator = taught();
  const std::string text = calibration_text(calibrator);
  for (const std::string& other :
       {replaced(text, "calibration 5", "calibration 6"), std::string(2000, '\4'), std::string()})
    EXPECT_FALSE(restore_calibration(other, calibrator).has_value());
  EXPECT_EQ(calibration_text(calibrator), text);
}

/// Damage with a valid checksum: every number of a line made another, at random places.
TEST(CalibrationState, NoDamagedTextGivesANumberThatIsNone) {
  const std::string text = calibration_text(taught());
  std::mt19937 random(8);
  for (int k = 0; k < 400; ++k) {
    std::string damaged = text;
    for (int n = 0; n < 3; ++n) damaged[random() % damaged.size()] = "0123456789.-e n"[random() % 15];
    calib::OnlineCalibrator calibrator({}, {});
    (void)restore_calibration(damaged, calibrator);
    EXPECT_EQ(calib::fault_of(calibrator.state()), "") << k;
    EXPECT_TRUE(vec(calibrator.snapshot().gyr.bias).allFinite());
    EXPECT_TRUE(vec(calibrator.snapshot().acc.bias).allFinite());
  }
}

}  // namespace
}  // namespace stillpoint::io
