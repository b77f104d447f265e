#include "pipeline/frame.h"

#include <gtest/gtest.h>

#include "core/so3.h"
#include "core/units.h"

namespace stillpoint::pipeline {
namespace {

/// A sensor somewhere in the world, and what it reads there at rest and while it turns.
struct Scene {
  fusion::AttitudeEstimate estimate;
  CalibratedSample sample;
};
Scene scene() {
  const Quat q_world_sensor = exp_quat(Vec3(0.4, -1.1, 0.7));
  Scene s;
  s.estimate.q_world_body = {q_world_sensor.w(), q_world_sensor.x(), q_world_sensor.y(), q_world_sensor.z()};
  s.estimate.rate_body_radps = {0.1, 0.2, -0.3};
  s.estimate.gyro_bias_radps = {0.01, 0.02, 0.03};
  s.sample.acc_mps2 = array(Vec3(q_world_sensor.conjugate() * Vec3(0, 0, kStandardGravity_mps2)));
  s.sample.mag_uT = array(Vec3(q_world_sensor.conjugate() * Vec3(0, 20, -43)));
  s.sample.gyr_radps = s.estimate.rate_body_radps;
  return s;
}

TEST(OutputFrame, ReadingsStandInTheFrameOfTheAttitudeBesideThem) {
  const Scene s = scene();
  for (const Quat& mount : {Quat::Identity(), exp_quat(Vec3(0.3, 0.2, -2.0))})
    for (const WorldFrame world : {WorldFrame::kEnu, WorldFrame::kNed}) {
      const OutputFrame frame{world, mount};
      const auto attitude = in_frame(s.estimate, frame);
      const CalibratedSample body = in_frame(s.sample, frame);
      const double up = world == WorldFrame::kEnu ? 1.0 : -1.0;  // of the specific force at rest: NED has z down
      const Vec3 field = world == WorldFrame::kEnu ? Vec3(0, 20, -43) : Vec3(20, 0, 43);
      EXPECT_LT((quat(attitude.q_world_body) * vec(body.acc_mps2) - Vec3(0, 0, up * kStandardGravity_mps2)).norm(),
                1e-12);
      EXPECT_LT((quat(attitude.q_world_body) * vec(body.mag_uT) - field).norm(), 1e-12);
      EXPECT_LT((vec(attitude.rate_body_radps) - vec(body.gyr_radps)).norm(), 1e-12);
      EXPECT_EQ(attitude.gyro_bias_radps, s.estimate.gyro_bias_radps) << "of the sensor's axes, as the calibration";
    }
}

}  // namespace
}  // namespace stillpoint::pipeline
