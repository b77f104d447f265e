#include "diagnosis/no_reference/closure.h"

#include "core/so3.h"

namespace stillpoint::diag::detail {
namespace {

constexpr double kOfHalfTheRate = 1.0 / 8.0;  // a method of third order; of fourth, as the turns mostly are, 1/16

Quat turned(const io::Recording& r, const std::vector<Vec3>& rate, std::size_t from, std::size_t to,
            std::size_t stride) {
  Quat q = Quat::Identity();
  for (std::size_t i = from + stride; i <= to; i += stride) q = (q * turn_between(r, rate, i - stride, i)).normalized();
  return q;
}

}  // namespace

Quat turn_between(const io::Recording& r, const std::vector<Vec3>& rate, std::size_t from, std::size_t to) {
  const std::size_t stride = to - from;
  const double dt = r.t_s(to) - r.t_s(from);
  const Vec3 &w0 = rate[from], &w1 = rate[to];
  const bool inside = from >= stride && to + stride < rate.size();
  const Vec3 bend = inside ? (w0 + w1 - rate[from - stride] - rate[to + stride]).eval() : Vec3::Zero().eval();
  return exp_quat(dt * (0.5 * (w0 + w1) + bend / 24.0) + dt * dt / 12.0 * w0.cross(w1));
}

double integration_error_rad(const io::Recording& r, const std::vector<Vec3>& rate, std::size_t from, std::size_t to) {
  const std::size_t last = to - (to - from) % 2;
  const Quat fine = turned(r, rate, from, last, 1), coarse = turned(r, rate, from, last, 2);
  return kOfHalfTheRate * log_quat(fine.conjugate() * coarse).norm();
}

}  // namespace stillpoint::diag::detail
