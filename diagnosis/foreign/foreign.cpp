#include "diagnosis/foreign/foreign.h"

#include <Eigen/Cholesky>
#include <cmath>

#include "diagnosis/reference/given_effects.h"
#include "diagnosis/reference/with_reference.h"
#include "diagnosis/sanity/comparison.h"
#include "diagnosis/sanity/rows_with_reference.h"
#include "diagnosis/sanity/sensor_rows.h"

namespace stillpoint::diag {
namespace {

/// The world's field in what the log says its magnetometer reads, beside an offset of the body.
Vec3 field_of(const AlignedLog& log) {
  Eigen::Matrix<double, 6, 6> G = Eigen::Matrix<double, 6, 6>::Identity() * 1e-6;
  Eigen::Matrix<double, 6, 1> g = Eigen::Matrix<double, 6, 1>::Zero();
  for (std::size_t i = 0; i < log.reference.size(); ++i) {
    const Eigen::Vector4d& q = log.reference.ref_q_world_body[i];
    const Vec3 reads = log.reading[kMag].row(static_cast<Eigen::Index>(i));
    if (!q.allFinite() || !reads.allFinite() || log.outside[i]) continue;
    Eigen::Matrix<double, 3, 6> row;
    row << detail::as_expected(q).conjugate().toRotationMatrix(), Mat3::Identity();
    G += row.transpose() * row;
    g += row.transpose() * reads;
  }
  return G.ldlt().solve(g).head<3>();
}

/// A simulation that changes nothing: what the log says is what the sensor should read. The noise is that of both.
sim::SimulationConfig nothing_added(const AlignedLog& log, const io::Recording& recording) {
  sim::SimulationConfig out;
  out.rate_hz = 1.0 / recording.median_step_s();
  const std::array<const std::vector<Vec3>*, kSensors> columns{&recording.acc_mps2, &recording.gyr_radps,
                                                               &recording.mag_uT};
  const std::array<std::optional<sim::TriadConfig>*, kSensors> triads{&out.accelerometer, &out.gyroscope,
                                                                      &out.magnetometer};
  for (std::size_t k = 0; k < kSensors; ++k)
    if (!columns[k]->empty() && log.reading[k].rows() > 0)
      *triads[k] = sim::TriadConfig{.noise_sd = std::hypot(log.own_noise_sd[k], log.noise_sd[k])};
  if (log.reading[kMag].rows() > 0) out.field_world_uT = field_of(log);
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
  const auto on_rows = readings_on_rows(given, notices);
  RowsWithReference with_frames;
  if (!given.ref_q_world_body.empty()) with_frames = rows_with_reference(on_rows ? *on_rows : given, notices);
  const io::Recording& recording = with_frames.changed ? *with_frames.changed : on_rows ? *on_rows : given;
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
  out.answer = diagnose_with_reference({aligned->reference, with_frames.rows_a_frame, &*aligned}, simulation, forensics,
                                       without, 0, progress, std::move(out.answer));
  const Result<Signals> signals = make_signals(aligned->reference, simulation, {}, &*aligned, with_frames.rows_a_frame);
  if (!signals) return tl::unexpected(signals.error());
  out.improved = improved_log(*aligned, *signals, out.answer);
  return out;
}

}  // namespace stillpoint::diag
