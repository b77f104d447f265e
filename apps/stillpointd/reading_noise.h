/// How noisy the readings are, for the covariances of the ROS 2 topics (REP-145): the white noise as the readings at
/// rest show it, and what the calibration does not know of their bias. Slow thread.
#pragma once
#include "core/attitude_message.h"
#include "core/calibration.h"
#include "core/types.h"

namespace stillpoint::app {

class ReadingNoise {
 public:
  /// `at_rest`: the body is held still, so that two readings differ by their noise.
  void add(const RawSample& sample, bool at_rest) noexcept;
  /// In the body's axes. Zeros: not known yet.
  [[nodiscard]] ReadingCovariances covariances(const CalibrationSnapshot& calibration,
                                               const Mat3& R_body_sensor) const noexcept;

 private:
  /// Half the mean square of the differences between one reading and the next.
  struct Triad {
    Array3 last{}, variance{};
    std::uint64_t last_sequence = 0;
    double weight = 0.0;  ///< readings behind the mean, at most the memory
    void add(const Array3& reading, std::uint64_t sequence, bool at_rest) noexcept;
    [[nodiscard]] Array9 covariance(const TriadCalibration& calibration, const Mat3& R_body_sensor) const noexcept;
  };
  Triad acc_, gyr_, mag_;
};

}  // namespace stillpoint::app
