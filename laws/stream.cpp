#include "laws/stream.h"

#include <algorithm>
#include <cmath>

#include "laws/elementwise.h"
#include "laws/evaluate.h"

namespace stillpoint::laws {
namespace {

constexpr double kRateStep_s = 1e-3;  // drivers of a simulation are smooth functions of time

bool keeps_state(Op op) { return op == Op::kLag || op == Op::kPlay || op == Op::kIntegral; }

std::size_t count_states(const Node& n) {
  std::size_t count = keeps_state(n.op) ? 1 : 0;
  for (const Node& a : n.args) count += count_states(a);
  return count;
}

}  // namespace

Stream::Stream(Node tree, double start_s) : tree_(std::move(tree)), start_s_(start_s), states_(count_states(tree_)) {}

Vec3 Stream::next(const DriverAt& drivers, double t_s) {
  if (!states_.empty()) at_ = 0;  // a law without memory is never written to: threads may share it
  return value(tree_, drivers, t_s);
}

Vec3 Stream::value(const Node& n, const DriverAt& drivers, double t_s) {
  if (n.op == Op::kNumber) return Vec3::Constant(n.number);
  if (n.op == Op::kDriver) return drivers(n.driver, t_s);
  if (n.op == Op::kComponent) return Vec3::Constant(drivers(n.driver, t_s)[static_cast<Eigen::Index>(n.component)]);
  if (keeps_state(n.op)) return remembered(n, drivers, t_s);
  if (n.op == Op::kRate) {
    const double span = rate_span_s(n), h = span > 0.0 ? span : kRateStep_s;
    const double later = t_s + h, earlier = std::max(start_s_, t_s - h);
    return (value(n.args[0], drivers, later) - value(n.args[0], drivers, earlier)) / (later - earlier);
  }
  if (n.op == Op::kDelay) return value(n.args[0], drivers, std::max(start_s_, t_s - n.args[1].number));
  const Vec3 a = value(n.args[0], drivers, t_s);
  switch (n.op) {
    case Op::kAdd:
      return a + value(n.args[1], drivers, t_s);
    case Op::kSubtract:
      return a - value(n.args[1], drivers, t_s);
    case Op::kMultiply:
      return a.cwiseProduct(value(n.args[1], drivers, t_s));
    case Op::kDivide:
      return a.cwiseQuotient(value(n.args[1], drivers, t_s));
    case Op::kCross:
      return a.cross(value(n.args[1], drivers, t_s));
    case Op::kNorm:
      return Vec3::Constant(a.norm());
    default:
      return elementwise(n.op, a, n.args.size() > 1 ? n.args[1].number : 0.0);
  }
}

Vec3 Stream::remembered(const Node& n, const DriverAt& drivers, double t_s) {
  const std::size_t mine = at_++;
  const Vec3 x = value(n.args[0], drivers, t_s);
  State& s = states_[mine];
  const double step = t_s - s.t_s, second = n.args.size() > 1 ? n.args[1].number : 0.0;
  if (!s.started) {
    s = {true, t_s, x, n.op == Op::kIntegral ? Vec3(Vec3::Zero()) : x};
    return s.value;
  }
  if (n.op == Op::kIntegral) s.value += 0.5 * step * (x + s.last);
  if (n.op == Op::kPlay)
    s.value = s.value.cwiseMax((x.array() - 0.5 * second).matrix()).cwiseMin((x.array() + 0.5 * second).matrix());
  if (n.op == Op::kLag && step > 0.0) {
    const double keep = std::exp(-step / second), slope = (step - second * (1.0 - keep)) / step;
    s.value = keep * s.value + (1.0 - keep) * s.last + slope * (x - s.last);
  }
  s.last = x;
  s.t_s = t_s;
  return s.value;
}

}  // namespace stillpoint::laws
