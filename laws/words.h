/// The functions of the grammar by name: one table for the parser, the text and the code emitters.
#pragma once
#include <array>
#include <string_view>

#include "laws/expression.h"

namespace stillpoint::laws {

struct Function {
  Op op;
  std::string_view name;
  std::size_t args;
  std::string_view example;
};

inline constexpr std::array kFunctions{
    Function{Op::kNorm, "norm", 1, "norm(w)"},
    Function{Op::kAbs, "abs", 1, "abs(f_x)"},
    Function{Op::kSign, "sign", 1, "sign(w_z)"},
    Function{Op::kExp, "exp", 1, "exp(-t / 30)"},
    Function{Op::kLog, "log", 1, "log(1 + t / 30)"},
    Function{Op::kSin, "sin", 1, "sin(f_x / 0.3)"},
    Function{Op::kCos, "cos", 1, "cos(f_x / 0.3)"},
    Function{Op::kTanh, "tanh", 1, "tanh(f_x / 20)"},
    Function{Op::kCross, "cross", 2, "cross(w, f)"},
    Function{Op::kStep, "step", 2, "step(t, 20)"},
    Function{Op::kRate, "d", 1, "d(T)"},
    Function{Op::kIntegral, "integral", 1, "integral(I)"},
    Function{Op::kLag, "lag", 2, "lag(I, 1.5)"},
    Function{Op::kDelay, "delay", 2, "delay(w, 0.01)"},
    Function{Op::kPlay, "play", 2, "play(m, 4)"},
};

[[nodiscard]] inline const Function* function_of(Op op) {
  for (const Function& f : kFunctions)
    if (f.op == op) return &f;
  return nullptr;
}

}  // namespace stillpoint::laws
