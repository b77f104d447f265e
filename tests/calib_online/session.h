/// A sensor that is calibrated by living: rests and turns of a made-up body through detector and calibrator.
#pragma once
#include <random>
#include <vector>

#include "calib_online/field_turns.h"
#include "calib_online/online_calibrator.h"
#include "calib_online/rest_detector.h"
#include "tests/calib_online/synthetic.h"

namespace stillpoint::test {

/// Rest in many attitudes with turns in between, as a hand would do it.
struct Session {
  Synthetic source;
  calib::RestDetector detector;
  calib::OnlineCalibrator calibrator;
  calib::FieldTurnFinder field_turns;
  std::vector<calib::Window> windows;

  Session(const SensorTruth& truth, unsigned seed, const calib::OnlineCalibratorParams& params = {})
      : source(truth, seed), calibrator(params, CalibrationSnapshot{}) {}

  void live(double duration_s, const Motion& motion = {}) {
    source.run(duration_s, motion, [this](const RawSample& s) {
      if (const auto turn = field_turns.push(s, 0, calibrator.snapshot(), {})) calibrator.absorb(*turn);
      if (auto w = detector.push(s, calibrator.snapshot())) {
        windows.push_back(*w);
        calibrator.absorb(*w);
      }
    });
  }

  void turns(int count, unsigned seed) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    for (int k = 0; k < count; ++k) {
      live(4.6);
      const Vec3 rate = 1.1 * Vec3(normal(random), normal(random), normal(random)).normalized();
      Motion turn;
      turn.rate_radps = [rate](double) { return rate; };
      live(1.4, turn);
    }
  }
};

inline SensorTruth consumer_sensor() {
  SensorTruth truth;
  truth.H_acc << 1.012, 0.003, -0.002, 0.003, 0.991, 0.004, -0.002, 0.004, 1.004;
  truth.b_acc = Vec3(0.21, -0.14, 0.3);
  truth.H_gyr << 1.015, 0.006, -0.004, -0.007, 0.988, 0.009, 0.003, -0.008, 1.006;
  truth.b_gyr = Vec3(0.006, -0.004, 0.005);
  return truth;
}

}  // namespace stillpoint::test
