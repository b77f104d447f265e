/// A sensor in ordinary use: handled, driven, shaken, dropped and swapped, with its truth, so that whatever the
/// calibration states can be held against it.
#pragma once
#include <memory>

#include "bench/calibration_tables.h"
#include "calib_online/field_turns.h"
#include "calib_online/online_calibrator.h"
#include "calib_online/rest_detector.h"

namespace stillpoint::bench {

/// y = H^-1 u + b + noise, of data-sheet size.
struct UsedSensor {
  Mat3 H_acc = Mat3::Identity(), H_gyr = Mat3::Identity();
  Vec3 b_acc_mps2 = Vec3::Zero(), b_gyr_radps = Vec3::Zero();  ///< at 25 degC
  Vec3 b_acc_mps2_per_K = Vec3::Zero(), b_gyr_radps_per_K = Vec3::Zero();
  double acc_lattice_mps2 = 0.0, gyr_lattice_radps = 0.0;  ///< the step of its readings; none where it is zero
  double acc_limit_mps2 = 1e9;                             ///< its readings end there
  explicit UsedSensor(Random& random);
};

/// What the surroundings do, in world axes; the body's own turns come on top.
struct Surroundings {
  std::function<Vec3(double)> force_mps2 = [](double) { return Vec3(Vec3::Zero()); };
  double vertical_rate_radps = 0.0;  ///< the ground turns: a turntable, a curve
  double shaking_mps2 = 0.0;         ///< amplitude at 29 Hz, body axes
  std::function<double(double)> temp_degC = [](double) { return kTold_degC; };
  static constexpr double kTold_degC = 25.0;  ///< what the thermometer tells, whatever it is
};

class OrdinaryUse {
 public:
  OrdinaryUse(unsigned seed, bool has_mag);

  void rest(double seconds);
  /// So many attitudes, each rested in for some seconds and reached by a turn by hand.
  void handle(int attitudes);
  void turn();
  /// Turned about a world axis without its being felt as a turn by hand: the bank of an aircraft.
  void tilt(const Vec3& axis_world, double angle_rad, double seconds);

  UsedSensor& sensor() { return sensor_; }
  Surroundings& surroundings() { return surroundings_; }
  Random& random() { return random_; }
  [[nodiscard]] double now_s() const { return t_s_; }
  /// Errors over stated deviations, as they are published now.
  struct Judgement {
    std::vector<double> error, stated;  ///< one or three numbers a quantity
  };
  [[nodiscard]] std::map<std::string, Judgement> judge() const;
  [[nodiscard]] const calib::OnlineCalibrator& calibrator() const { return calibrator_; }

 private:
  void step(const Vec3& rate_body_radps);
  [[nodiscard]] Vec3 acc_bias_mps2() const;
  [[nodiscard]] Vec3 gyr_bias_radps() const;
  Random random_;
  UsedSensor sensor_;
  Surroundings surroundings_;
  bool has_mag_;
  calib::RestDetector detector_;
  calib::FieldTurnFinder turns_;
  calib::OnlineCalibrator calibrator_;
  Quat q_world_body_ = Quat::Identity();
  double t_s_ = 1.0;
};

/// One story: it calls `judge` wherever something is held against the truth.
struct UseCase {
  const char* name;
  bool has_mag;
  std::function<void(OrdinaryUse&, const std::function<void()>& judge)> live;
};
[[nodiscard]] const std::vector<UseCase>& use_cases();

/// Of one case and quantity over the seeds: share inside 3 stated sd, rms of error and of what was stated, at the end.
struct UseScore {
  double inside_percent = 100.0, error = 0.0, stated = 0.0;
  int judged = 0, stated_at_all = 0;
};
[[nodiscard]] std::map<std::string, UseScore> score(const UseCase& use, unsigned first_seed, unsigned seeds);

}  // namespace stillpoint::bench
