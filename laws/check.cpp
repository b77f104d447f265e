/// What each node is - number or vector - and its unit; refuses what has no meaning.
#include <fmt/format.h>

#include <cmath>

#include "laws/expression.h"
#include "laws/words.h"

namespace stillpoint::laws {
namespace {

using Checked = tl::expected<Node, Fault>;

tl::unexpected<Fault> fault(const Node& at, std::string what) {
  return tl::unexpected(Fault{at.column, std::move(what)});
}

/// Made of numbers only: it takes the unit of what it is added to.
bool constant(const Node& n) {
  if (n.op == Op::kDriver || n.op == Op::kComponent) return false;
  for (const Node& a : n.args)
    if (!constant(a)) return false;
  return true;
}

/// A number that scales the argument may bear its unit: sin(f_x / 0.3), exp(-t / 30).
bool scaled_by_number(const Node& n) {
  if (n.op == Op::kNegate) return scaled_by_number(n.args[0]);
  if (n.op == Op::kAdd || n.op == Op::kSubtract)
    return (constant(n.args[0]) || scaled_by_number(n.args[0])) && (constant(n.args[1]) || scaled_by_number(n.args[1]));
  if (n.op == Op::kMultiply)
    return constant(n.args[0]) || constant(n.args[1]) || scaled_by_number(n.args[0]) || scaled_by_number(n.args[1]);
  if (n.op == Op::kDivide) return constant(n.args[1]) || scaled_by_number(n.args[0]);
  return false;
}

/// Depends on more of the past than a moment of it.
bool has_history(const Node& n) {
  if (n.op == Op::kLag || n.op == Op::kPlay || n.op == Op::kIntegral) return true;
  for (const Node& a : n.args)
    if (has_history(a)) return true;
  return false;
}

std::string shape(bool vector) { return vector ? "a vector" : "a number"; }

Checked check_sum(Node n) {
  const Node &a = n.args[0], &b = n.args[1];
  if (a.vector != b.vector) return fault(n, fmt::format("{} and {} cannot be added", shape(a.vector), shape(b.vector)));
  const bool free_a = constant(a), free_b = constant(b);
  if (!free_a && !free_b && !(a.unit == b.unit))
    return fault(n,
                 fmt::format("unlike units are added: {} and {}; multiply one by a driver that has the missing unit, "
                             "or write two laws",
                             text(a.unit), text(b.unit)));
  n.vector = a.vector;
  n.unit = free_a ? b.unit : a.unit;
  return n;
}

Checked check_power(Node n) {
  if (n.args[1].op != Op::kNumber) return fault(n.args[1], "an exponent must be a number, as in norm(w)^2");
  n.vector = n.args[0].vector;
  n.unit = n.args[0].unit.to_the(n.args[1].number);
  return n;
}

Checked check_transcendental(Node n, const Function& f) {
  if (n.args[0].vector) {
    n.vector = true;
  }
  if (!n.args[0].unit.plain() && !scaled_by_number(n.args[0]))
    return fault(n, fmt::format("{} needs a pure number, its argument is in {}; divide by a constant, as in {}", f.name,
                                text(n.args[0].unit), f.example));
  return n;
}

/// The second argument of lag, delay, play and step is a number of the law itself.
Checked check_with_constant(Node n, const Function& f) {
  const Node& c = n.args[1];
  if (c.op != Op::kNumber)
    return fault(c, fmt::format("the second argument of {} must be a number, as in {}", f.name, f.example));
  if (f.op == Op::kDelay && has_history(n.args[0]))
    return fault(n, "delay takes what has no history; write lag(delay(x, s), tau) for delay(lag(x, tau), s)");
  const bool above = f.op == Op::kLag || f.op == Op::kPlay;
  if ((above && c.number <= 0.0) || (f.op == Op::kDelay && c.number < 0.0))
    return fault(c, fmt::format("{} needs a number {} 0", f.name, above ? "greater than" : "of at least"));
  n.vector = n.args[0].vector;
  n.unit = f.op == Op::kStep ? Unit{} : n.args[0].unit;
  return n;
}

Checked check_function(Node n) {
  const Function& f = *function_of(n.op);
  const Node& a = n.args[0];
  switch (n.op) {
    case Op::kExp:
    case Op::kLog:
    case Op::kSin:
    case Op::kCos:
    case Op::kTanh:
      return check_transcendental(std::move(n), f);
    case Op::kStep:
    case Op::kLag:
    case Op::kDelay:
    case Op::kPlay:
      return check_with_constant(std::move(n), f);
    case Op::kCross:
      if (!a.vector || !n.args[1].vector) return fault(n, "cross takes two vectors, as in cross(w, f)");
      n.vector = true;
      n.unit = a.unit * n.args[1].unit;
      return n;
    case Op::kNorm:
      if (!a.vector) return fault(n, "norm takes a vector, as in norm(w); of a number take abs");
      n.unit = a.unit;
      return n;
    default:
      break;
  }
  if (n.op == Op::kRate && has_history(a))
    return fault(n, "d takes what has no history; write lag(d(x), tau) for d(lag(x, tau))");
  n.vector = a.vector;
  n.unit = n.op == Op::kSign       ? Unit{}
           : n.op == Op::kRate     ? a.unit / Unit::of(Unit::kSecond)
           : n.op == Op::kIntegral ? a.unit * Unit::of(Unit::kSecond)
                                   : a.unit;
  return n;
}

}  // namespace

Checked checked(Node n, const Signature& drivers) {
  for (Node& a : n.args) {
    Checked inner = checked(std::move(a), drivers);
    if (!inner) return inner;
    a = std::move(*inner);
  }
  switch (n.op) {
    case Op::kNumber:
      return n;
    case Op::kDriver:
    case Op::kComponent: {
      const DriverInfo& info = drivers.find(n.driver)->second;
      if (n.op == Op::kComponent && !info.vector)
        return fault(n, fmt::format("'{}' is a number and has no axes", n.driver));
      n.vector = info.vector && n.op == Op::kDriver;
      n.unit = info.unit;
      return n;
    }
    case Op::kNegate:
      n.vector = n.args[0].vector;
      n.unit = n.args[0].unit;
      return n;
    case Op::kAdd:
    case Op::kSubtract:
      return check_sum(std::move(n));
    case Op::kMultiply:
    case Op::kDivide:
      if (n.op == Op::kDivide && n.args[1].vector) return fault(n, "a vector cannot divide; take its norm or one axis");
      n.vector = n.args[0].vector || n.args[1].vector;
      n.unit = n.op == Op::kMultiply ? n.args[0].unit * n.args[1].unit : n.args[0].unit / n.args[1].unit;
      return n;
    case Op::kPower:
      return check_power(std::move(n));
    default:
      return check_function(std::move(n));
  }
}

}  // namespace stillpoint::laws
