/// The filter over a recording, and the online calibration fed piece by piece.
#include "core/units.h"
#include "pipeline/smooth.h"
#include "pipeline/stages.h"
#include "python/native.h"

namespace stillpoint::python {
namespace {

/// One row a sample that was used, as it is published.
struct Track {
  std::vector<double> time_s, q_wxyz, covariance, sigma, rate, bias;
  std::vector<std::uint8_t> at_rest, status, heading;
  CalibrationSnapshot calibration;

  void reserve(std::size_t n) {
    time_s.reserve(n);
    for (auto* triple : {&sigma, &rate, &bias}) triple->reserve(3 * n);
    q_wxyz.reserve(4 * n);
    covariance.reserve(9 * n);
    for (auto* flag : {&at_rest, &status, &heading}) flag->reserve(n);
  }
  void add(const AttitudeMessage& m) {
    const auto append = [](std::vector<double>& to, const auto& from) {
      to.insert(to.end(), from.begin(), from.end());
    };
    const auto& q = m.q_world_body_xyzw;
    time_s.push_back(in_seconds(m.t_ns));
    append(q_wxyz, std::array{q[3], q[0], q[1], q[2]});
    append(covariance, m.orientation_covariance_rad2);
    append(sigma, m.sigma_rpy_rad);
    append(rate, m.rate_radps);
    append(bias, m.gyro_bias_radps);
    at_rest.push_back(m.at_rest ? 1 : 0);
    status.push_back(static_cast<std::uint8_t>(m.status));
    heading.push_back(static_cast<std::uint8_t>(m.heading_reference));
  }
};

Track run(const io::Recording& recording, const c_api::Settings& settings, const CalibrationSnapshot& factory,
          bool smooth) {
  Track track;
  track.reserve(recording.size());
  calib::OnlineCalibrator calibrator(settings.calibrator, factory);
  if (smooth) {
    const auto sample = [&recording](std::size_t row) { return recording.sample(row); };
    const pipeline::Smoothed smoothed = pipeline::smooth(recording.size(), sample, settings.stages, calibrator);
    for (const pipeline::Processed& row : smoothed.rows) track.add(to_message(row));
    track.calibration = smoothed.stages.live();
    return track;
  }
  pipeline::DirectLink link(calibrator);
  pipeline::Stages stages(settings.stages, factory);
  pipeline::Processed out;
  for (std::size_t row = 0; row < recording.size(); ++row)
    if (stages.process(recording.sample(row), out, link) != pipeline::StageStatus::kDrop) track.add(to_message(out));
  track.calibration = stages.live();
  return track;
}

/// The vector's own memory, kept alive by the array.
template <class T>
py::array as_array(std::vector<T>&& values, std::vector<py::ssize_t> shape) {
  auto* const kept = new std::vector<T>(std::move(values));
  const py::capsule owner(kept, [](void* p) { delete static_cast<std::vector<T>*>(p); });
  return py::array_t<T>(std::move(shape), kept->data(), owner);
}

py::dict estimate(const io::Recording& recording, const SettingList& list, const py::dict& factory, bool smooth) {
  const c_api::Settings settings = settings_from(list);
  const CalibrationSnapshot start = calibration_from(factory);
  Track track;
  {
    const py::gil_scoped_release free;
    track = run(recording, settings, start, smooth);
  }
  const auto n = static_cast<py::ssize_t>(track.time_s.size());
  py::dict d;
  d["time_s"] = as_array(std::move(track.time_s), {n});
  d["q_wxyz"] = as_array(std::move(track.q_wxyz), {n, 4});
  d["covariance_rad2"] = as_array(std::move(track.covariance), {n, 3, 3});
  d["sigma_rpy_rad"] = as_array(std::move(track.sigma), {n, 3});
  d["rate_radps"] = as_array(std::move(track.rate), {n, 3});
  d["gyro_bias_radps"] = as_array(std::move(track.bias), {n, 3});
  d["at_rest"] = as_array(std::move(track.at_rest), {n});
  d["status"] = as_array(std::move(track.status), {n});
  d["heading"] = as_array(std::move(track.heading), {n});
  d["calibration"] = calibration_to(track.calibration);
  return d;
}

/// Rest detection and calibration without the filter.
class Calibrator {
 public:
  Calibrator(const SettingList& list, const py::dict& factory)
      : settings_(settings_from(list)),
        assemble_(settings_.stages.guard.late_s, calibration_from(factory).gyr),
        rest_(settings_.stages.rest),
        calibrator_(settings_.calibrator, calibration_from(factory)) {}

  /// How many rest windows it held.
  std::size_t push(const io::Recording& recording) {
    const py::gil_scoped_release free;
    std::size_t windows = 0;
    for (std::size_t row = 0; row < recording.size(); ++row) {
      pipeline::GuardedSample alone, guarded;
      if (guard_.process(recording.sample(row), alone) == pipeline::StageStatus::kDrop) continue;
      if (assemble_.process(alone, guarded) == pipeline::StageStatus::kDrop) continue;
      const CalibrationSnapshot& live = calibrator_.snapshot();
      if (const auto window = rest_.push(guarded.sample, live)) {
        calibrator_.absorb(*window);
        assemble_.use(live.gyr);
        ++windows;
      }
      if (const auto turn = turns_.push(guarded.sample, guarded.clipped, live, guarded.mag_turn_rad))
        calibrator_.absorb(*turn);
    }
    return windows;
  }
  [[nodiscard]] py::dict calibration() const { return calibration_to(calibrator_.snapshot()); }

 private:
  c_api::Settings settings_;
  pipeline::GuardStage guard_{settings_.stages.guard};
  pipeline::AssembleStage assemble_;
  calib::RestDetector rest_;
  calib::FieldTurnFinder turns_;
  calib::OnlineCalibrator calibrator_;
};

}  // namespace

void bind_estimate(py::module_& m) {
  m.def("estimate", &estimate);
  py::class_<Calibrator>(m, "Calibrator")
      .def(py::init<const SettingList&, const py::dict&>())
      .def("push", &Calibrator::push)
      .def("calibration", &Calibrator::calibration);
}

}  // namespace stillpoint::python
