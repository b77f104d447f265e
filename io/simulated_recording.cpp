#include "io/simulated_recording.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace stillpoint::io {
namespace {

void append_triad(const Array3& value, const RawSample& s, SamplePart part, std::vector<Vec3>& column,
                  std::size_t rows) {
  if (!s.holds(part) && column.empty()) return;
  column.resize(rows - 1, Vec3::Constant(kMissing));
  column.push_back(s.holds(part) ? Vec3(vec(value)) : Vec3::Constant(kMissing));
}

bool has_reference(const Recording& r, std::size_t row) { return r.ref_q_world_body[row].allFinite(); }

double start_of_reference_s(const Recording& r) {
  for (std::size_t i = 0; i < r.ref_q_world_body.size(); ++i)
    if (has_reference(r, i)) return r.t_s(i);
  return r.size() > 0 ? r.t_s(0) : 0.0;
}

/// A thermometer's noise and lattice are not the temperature: means over a second to either side, straight lines at the
/// ends, so that a slope stays one.
std::vector<double> without_thermometer_noise(const sim::TimeSeries& x) {
  constexpr double kHalf_s = 1.0;
  std::vector<double> out(x.value.size());
  std::vector<double> sum(x.value.size() + 1, 0.0);
  for (std::size_t i = 0; i < x.value.size(); ++i) sum[i + 1] = sum[i] + x.value[i];
  std::size_t a = 0, b = 0;
  for (std::size_t i = 0; i < out.size(); ++i) {
    const double half = std::min({kHalf_s, x.t_s[i] - x.t_s.front(), x.t_s.back() - x.t_s[i]});
    while (x.t_s[a] < x.t_s[i] - half) ++a;
    while (b < out.size() && x.t_s[b] <= x.t_s[i] + half) ++b;
    out[i] = (sum[b] - sum[a]) / static_cast<double>(b - a);
  }
  return out;
}

}  // namespace

void append(const sim::SimulatedSample& row, Recording& to) {
  to.t_ns.push_back(row.sample.t_ns);
  append_triad(row.sample.acc_mps2, row.sample, kAcc, to.acc_mps2, to.size());
  append_triad(row.sample.gyr_radps, row.sample, kGyr, to.gyr_radps, to.size());
  append_triad(row.sample.mag_uT, row.sample, kMag, to.mag_uT, to.size());
  to.temp_degC.push_back(row.sample.temp_degC);
  to.current_A.push_back(row.current_A);
  to.supply_V.push_back(row.supply_V);
  if (!row.has_reference) return;
  const Quat& q = row.ref_q_world_body;
  to.ref_q_world_body.emplace_back(q.w(), q.x(), q.y(), q.z());
  to.ref_position_m.push_back(row.ref_position_m);
  to.ref_moving.push_back(row.moving ? 1.0 : 0.0);
}

Recording to_recording(const std::vector<sim::SimulatedSample>& rows) {
  Recording out;
  out.header["source"] = "stillpoint simulate";
  out.header["world_frame"] = "ENU";
  for (const auto& row : rows) append(row, out);
  return out;
}

SimulatedRecordingFile::SimulatedRecordingFile(OutputFile file, const sim::SimulationConfig& c)
    : file_(std::move(file)),
      has_{c.accelerometer.has_value(), c.gyroscope.has_value(), c.magnetometer.has_value()},
      part_(to_recording({})) {}

Result<SimulatedRecordingFile> SimulatedRecordingFile::create(const std::string& path,
                                                              const sim::SimulationConfig& config) {
  auto file = OutputFile::create(path);
  if (!file) return tl::unexpected(file.error());
  return SimulatedRecordingFile(std::move(*file), config);
}

Result<void> SimulatedRecordingFile::add(const sim::SimulatedSample& row) {
  constexpr std::size_t kRowsOfAPart = 50'000;
  append(row, part_);
  return part_.size() < kRowsOfAPart ? Result<void>{} : write_part();
}

Result<void> SimulatedRecordingFile::write_part() {
  std::vector<Vec3>* columns[] = {&part_.acc_mps2, &part_.gyr_radps, &part_.mag_uT};
  for (std::size_t i = 0; i < 3; ++i)
    if (has_[i]) columns[i]->resize(part_.size(), Vec3::Constant(kMissing));
  if (!std::exchange(begun_, true))
    if (auto written = write_header(part_, file_); !written) return written;
  auto written = write_rows(part_, file_);
  part_ = {};
  return written;
}

Result<void> SimulatedRecordingFile::finish() {
  if (auto written = write_part(); !written) return written;
  return file_.flush();
}

sim::ReferenceTrack reference_track(const Recording& r) {
  sim::ReferenceTrack track;
  const bool told = std::any_of(r.ref_moving.begin(), r.ref_moving.end(), [](double m) { return m == 0.0; });
  const double start_s = start_of_reference_s(r);
  for (std::size_t i = 0; i < r.ref_q_world_body.size(); ++i) {
    const bool placed = r.ref_position_m.empty() || r.ref_position_m[i].allFinite();
    if (!has_reference(r, i) || !placed || r.ref_q_world_body[i].norm() < 0.5) continue;
    const auto& q = r.ref_q_world_body[i];
    track.t_s.push_back(r.t_s(i) - start_s);
    track.q_world_body.emplace_back(q[0], q[1], q[2], q[3]);
    if (!r.ref_position_m.empty()) track.position_m.push_back(r.ref_position_m[i]);
    if (told) track.moving.push_back(r.ref_moving[i] != 0.0);
  }
  return track;
}

sim::RecordedEnvironment recorded_environment(const Recording& r) {
  sim::RecordedEnvironment out;
  const double start_s = start_of_reference_s(r);
  const auto take = [&](const std::vector<double>& column, sim::TimeSeries& to) {
    for (std::size_t i = 0; i < column.size(); ++i) {
      if (!std::isfinite(column[i])) continue;
      to.t_s.push_back(r.t_s(i) - start_s);
      to.value.push_back(column[i]);
    }
  };
  take(r.temp_degC, out.temp_degC);
  take(r.current_A, out.current_A);
  take(r.supply_V, out.supply_V);
  out.temp_degC.value = without_thermometer_noise(out.temp_degC);
  for (const auto& [name, column] : r.user_columns) take(column, out.user[name]);
  return out;
}

}  // namespace stillpoint::io
