#include "apps/stillpointd/reading_noise.h"

#include <algorithm>

namespace stillpoint::app {
namespace {

constexpr double kMemory = 2000.0;  // readings: 20 s of rest at 100 Hz
constexpr double kEnough = 50.0;    // a variance from fewer is off by more than a fifth

}  // namespace

void ReadingNoise::Triad::add(const Array3& reading, std::uint64_t sequence, bool at_rest) noexcept {
  if (at_rest && last_sequence + 1 == sequence) {
    weight = std::min(weight + 1.0, kMemory);
    for (std::size_t i = 0; i < 3; ++i) {
      const double step = reading[i] - last[i];
      variance[i] += (0.5 * step * step - variance[i]) / weight;
    }
  }
  last = reading;
  last_sequence = sequence;
}

Array9 ReadingNoise::Triad::covariance(const TriadCalibration& calibration, const Mat3& R_body_sensor) const noexcept {
  if (weight < kEnough) return {};
  const Mat3 of_reading = Mat3(vec(variance).asDiagonal()) + Mat3(mat(calibration.bias_covariance));
  const Mat3 to_body = R_body_sensor * Mat3(mat(calibration.matrix));
  return array(Mat3(to_body * of_reading * to_body.transpose()));
}

void ReadingNoise::add(const RawSample& sample, bool at_rest) noexcept {
  if (sample.holds(kAcc)) acc_.add(sample.acc_mps2, sample.sequence, at_rest);
  if (sample.holds(kGyr)) gyr_.add(sample.gyr_radps, sample.sequence, at_rest);
  if (sample.holds(kMag)) mag_.add(sample.mag_uT, sample.sequence, at_rest);
}

ReadingCovariances ReadingNoise::covariances(const CalibrationSnapshot& calibration,
                                             const Mat3& R_body_sensor) const noexcept {
  return {acc_.covariance(calibration.acc, R_body_sensor), gyr_.covariance(calibration.gyr, R_body_sensor),
          mag_.covariance(calibration.mag, R_body_sensor)};
}

}  // namespace stillpoint::app
