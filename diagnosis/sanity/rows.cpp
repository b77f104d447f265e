#include "diagnosis/sanity/rows.h"

namespace stillpoint::diag::detail {
namespace {

void set_missing(double& x) { x = io::kMissing; }
template <class Vector>
void set_missing(Vector& x) {
  x.setConstant(io::kMissing);
}

template <class F>
void each_column(const io::Recording& from, io::Recording& to, F&& f) {
  f(from.acc_mps2, to.acc_mps2), f(from.gyr_radps, to.gyr_radps), f(from.mag_uT, to.mag_uT);
  f(from.temp_degC, to.temp_degC), f(from.current_A, to.current_A), f(from.supply_V, to.supply_V);
  f(from.ref_q_world_body, to.ref_q_world_body), f(from.ref_position_m, to.ref_position_m);
  f(from.ref_moving, to.ref_moving);
}

}  // namespace

io::Recording without_rows(const io::Recording& r) {
  io::Recording out;
  out.header = r.header, out.issues = r.issues;
  out.acc_in_counts = r.acc_in_counts, out.gyr_in_counts = r.gyr_in_counts, out.mag_in_counts = r.mag_in_counts;
  return out;
}

void append_row(const io::Recording& from, std::size_t row, io::Recording& to) {
  to.t_ns.push_back(from.t_ns[row]);
  each_column(from, to, [row](const auto& column, auto& out) {
    if (!column.empty()) out.push_back(column[row]);
  });
}

void append_empty_row(const io::Recording& from, std::int64_t t_ns, io::Recording& to) {
  to.t_ns.push_back(t_ns);
  each_column(from, to, [](const auto& column, auto& out) {
    if (!column.empty()) set_missing(out.emplace_back());
  });
}

}  // namespace stillpoint::diag::detail
