// Rest detection and online calibration without the filter, on a simulated sensor whose gyroscope is 0.02 rad/s off.
// Needs Stillpoint::calib_online and Stillpoint::simulation.
#include <stillpoint/calib_online/online_calibrator.h>
#include <stillpoint/calib_online/rest_detector.h>
#include <stillpoint/simulation/simulator.h>

#include <cstdio>

int main() {
  stillpoint::sim::SimulationConfig sensor;
  sensor.accelerometer = stillpoint::sim::TriadConfig{.noise_sd = 0.02};
  sensor.gyroscope = stillpoint::sim::TriadConfig{.bias = {0.02, -0.01, 0.0}, .noise_sd = 0.001};
  sensor.motion = stillpoint::sim::MotionConfig{.kind = "hand", .duration_s = 60.0};

  stillpoint::calib::RestDetector rest;
  stillpoint::calib::OnlineCalibrator calibrator({}, {});
  for (const auto& row : stillpoint::sim::simulate(sensor, /*seed=*/1))
    if (const auto window = rest.push(row.sample, calibrator.snapshot())) calibrator.absorb(*window);

  const auto& gyr = calibrator.snapshot().gyr;
  std::printf("gyroscope bias %.4f %.4f %.4f rad/s from %u rest windows: %s\n", gyr.bias[0], gyr.bias[1], gyr.bias[2],
              gyr.windows, name(gyr.status).data());
}
