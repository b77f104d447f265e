#include "diagnosis/foreign/foreign.h"

#include "diagnosis/reference/given_effects.h"
#include "diagnosis/reference/with_reference.h"
#include "diagnosis/sanity/readings.h"

namespace stillpoint::diag {
namespace {

/// A simulation that changes nothing: what the log says is what the sensor should read. The noise is the recording's.
sim::SimulationConfig nothing_added(const AlignedLog& log, const io::Recording& recording) {
  sim::SimulationConfig out;
  const double step_s = recording.median_step_s();
  out.rate_hz = 1.0 / step_s;
  const std::array<const std::vector<Vec3>*, kSensors> columns{&recording.acc_mps2, &recording.gyr_radps,
                                                               &recording.mag_uT};
  const std::array<std::optional<sim::TriadConfig>*, kSensors> triads{&out.accelerometer, &out.gyroscope,
                                                                      &out.magnetometer};
  for (std::size_t k = 0; k < kSensors; ++k)
    if (!columns[k]->empty() && log.reading[k].rows() > 0)
      *triads[k] = sim::TriadConfig{.noise_sd = quiet_noise(filled3(*columns[k]), step_s)};
  if (log.reading[kMag].rows() == 0) return out;
  Vec3 field = Vec3::Zero();
  for (std::size_t i = 0; i < recording.size(); ++i) {
    const Eigen::Vector4d& q = log.reference.ref_q_world_body[i];
    if (q.allFinite())
      field += Quat(q[0], q[1], q[2], q[3]) * Vec3(log.reading[kMag].row(static_cast<Eigen::Index>(i)));
  }
  out.field_world_uT = field / static_cast<double>(recording.size());
  return out;
}

std::vector<Vec3> column_of(const Series3& x, const Mask& outside) {
  std::vector<Vec3> out;
  for (Eigen::Index i = 0; i < x.rows(); ++i)
    out.push_back(outside[static_cast<std::size_t>(i)] ? Vec3::Constant(io::kMissing) : Vec3(x.row(i)));
  return out;
}

io::Recording improved_log(const AlignedLog& log, const Signals& before, const Answer& answer) {
  Signals after = before;
  static_cast<void>(subtract_effects(after, answer.effects));
  io::Recording out = log.reference;
  const std::array<std::vector<Vec3>*, kSensors> columns{&out.acc_mps2, &out.gyr_radps, &out.mag_uT};
  for (const Sensor k : {kAcc, kGyr, kMag}) {
    columns[k]->clear();
    if (!before.present[k] || before.residual[k].rows() == 0) continue;
    Series3 reads = before.predicted[k] + before.residual[k] - after.residual[k];
    if (const auto& right = answer.numbers[k]) reads = uncorrected(*right, reads);
    *columns[k] = column_of(reads, log.outside);
  }
  return out;
}

}  // namespace

Result<LogAnswer> diagnose_log(const io::Recording& log, const io::Recording& given,
                               const std::vector<std::string>& without, const std::function<void(double)>& progress) {
  std::vector<std::string> notices;
  const auto clean = without_false_values(given, notices);
  const io::Recording& recording = clean ? *clean : given;
  auto aligned = align(log, recording);
  if (!aligned) return tl::unexpected(aligned.error());
  LogAnswer out;
  const sim::SimulationConfig simulation = nothing_added(*aligned, recording);
  const Forensics forensics = examine_raw_values(recording, simulation);
  auto& told = out.answer.diagnosis.notices;
  const auto tell = [&told](const std::vector<std::string>& list) {
    told.insert(told.end(), list.begin(), list.end());
  };
  tell(notices), tell(aligned->notices), tell(forensics.notices);
  out.answer = diagnose_with_reference({aligned->reference, 1, &*aligned}, simulation, forensics, without, 0, progress,
                                       std::move(out.answer));
  const Result<Signals> signals = make_signals(aligned->reference, simulation, {}, &*aligned);
  if (!signals) return tl::unexpected(signals.error());
  out.improved = improved_log(*aligned, *signals, out.answer);
  return out;
}

}  // namespace stillpoint::diag
