/// Operations on each number by itself: one table for a whole recording and for one instant. Internal to laws.
#pragma once
#include <Eigen/Core>

#include "laws/expression.h"

namespace stillpoint::laws {

/// Pre: `op` takes one argument, keeps no state and is not kNorm. `second` is the power or the threshold.
template <class Values>
Values elementwise(Op op, const Values& a, double second) {
  switch (op) {
    case Op::kNegate:
      return -a;
    case Op::kPower:
      return a.array().pow(second);
    case Op::kAbs:
      return a.cwiseAbs();
    case Op::kSign:
      return a.cwiseSign();
    case Op::kExp:
      return a.array().exp();
    case Op::kLog:
      return a.array().log();
    case Op::kSin:
      return a.array().sin();
    case Op::kCos:
      return a.array().cos();
    case Op::kTanh:
      return a.array().tanh();
    default:
      return (a.array() > second).template cast<double>();
  }
}

}  // namespace stillpoint::laws
