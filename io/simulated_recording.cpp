#include "io/simulated_recording.h"

namespace stillpoint::io {
namespace {

void append_triad(const Array3& value, const RawSample& s, SamplePart part, std::vector<Vec3>& column,
                  std::size_t rows) {
  if (!s.holds(part) && column.empty()) return;
  column.resize(rows - 1, Vec3::Constant(kMissing));
  column.push_back(s.holds(part) ? Vec3(vec(value)) : Vec3::Constant(kMissing));
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

}  // namespace stillpoint::io
