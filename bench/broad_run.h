/// The path of a sample as the daemon takes it, over a whole recording: rest detection, correction, filter.
#pragma once
#include <vector>

#include "bench/broad_score.h"
#include "calib_online/rest_detector.h"
#include "fusion/attitude_filter.h"

namespace stillpoint::bench {

inline CalibratedSample corrected(const RawSample& raw, const CalibrationSnapshot& calibration) {
  CalibratedSample s;
  s.t_ns = raw.t_ns;
  s.sequence = raw.sequence;
  s.acc_mps2 = array(calibration.acc.apply(raw.acc_mps2, raw.temp_degC));
  s.gyr_radps = array(calibration.gyr.apply(raw.gyr_radps, raw.temp_degC));
  s.mag_uT = array(calibration.mag.apply(raw.mag_uT, raw.temp_degC));
  s.temp_degC = raw.temp_degC;
  s.has = raw.has;
  return s;
}

/// The attitude after every row; the calibration stays the factory's.
inline std::vector<Quat> run_stillpoint(const io::Recording& recording, const fusion::AttitudeFilterParams& params) {
  calib::RestDetector rest;
  fusion::AttitudeFilter filter(params);
  const CalibrationSnapshot calibration;
  std::vector<Quat> out;
  out.reserve(recording.size());
  for (std::size_t i = 0; i < recording.size(); ++i) {
    const RawSample raw = recording.sample(i);
    rest.push(raw, calibration);
    const Array4 q = filter.step(corrected(raw, calibration), rest.at_rest()).q_world_body;
    out.emplace_back(q[0], q[1], q[2], q[3]);
  }
  return out;
}

/// BROAD's score. Without a heading reference, the one turn about the vertical that fits best is taken out first.
inline Score score(const io::Recording& r, const std::vector<Quat>& estimates, bool without_heading) {
  const auto reference = [&r](std::size_t i) { return r.ref_q_world_body[i]; };
  double w = 0.0, z = 0.0;
  for (std::size_t i = 0; without_heading && i < r.size(); ++i) {
    if (!(r.ref_moving[i] == 1.0) || !reference(i).allFinite()) continue;
    const Quat e = estimates[i] * Quat(reference(i)(0), reference(i)(1), reference(i)(2), reference(i)(3)).conjugate();
    const double half2 = 2.0 * std::atan2(e.z(), e.w());
    w += std::cos(half2);
    z += std::sin(half2);
  }
  const Quat align(Eigen::AngleAxisd(-std::atan2(z, w), Vec3::UnitZ()));
  Scorer scorer;
  for (std::size_t i = 0; i < r.size(); ++i) {
    scorer.add(without_heading ? align * estimates[i] : estimates[i], reference(i), r.ref_moving[i]);
  }
  return scorer.score();
}

}  // namespace stillpoint::bench
