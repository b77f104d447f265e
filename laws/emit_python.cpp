#include <fmt/format.h>

#include "laws/emit_language.h"

namespace stillpoint::laws {
namespace {

constexpr const char* kPythonHelpers = R"(import math


def _v(f, *a):
    return [f(*c) for c in zip(*a)]


def _each(f, x):
    return [f(c) for c in x] if isinstance(x, list) else f(x)


def _both(f, a, b):
    return [f(p, q) for p, q in zip(a, b)] if isinstance(a, list) else f(a, b)


def _norm(a):
    return math.sqrt(a[0] ** 2 + a[1] ** 2 + a[2] ** 2)


def _cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def _sign(x):
    return (x > 0) - (x < 0)


def _at(t, x, s):
    s = min(max(s, t[0]), t[-1])
    lo, hi = 0, len(t) - 1
    while hi - lo > 1:
        mid = (lo + hi) // 2
        lo, hi = (mid, hi) if t[mid] <= s else (lo, mid)
    if hi == lo:
        return x[lo]
    share = (s - t[lo]) / (t[hi] - t[lo])
    return _both(lambda p, q: (1.0 - share) * p + share * q, x[lo], x[hi])


def _rate(t, x, span):
    out, last = [], len(t) - 1
    for i in range(len(t)):
        if span > 0.0:
            a, b = max(t[i] - span, t[0]), min(t[i] + span, t[last])
            before, after = _at(t, x, a), _at(t, x, b)
        else:
            j, k = max(i - 1, 0), min(i + 1, last)
            a, b, before, after = t[j], t[k], x[j], x[k]
        out.append(_both(lambda p, q: (q - p) / (b - a), before, after))
    return out


def _integral(t, x):
    out = [_each(lambda c: 0.0, x[0])]
    for i in range(1, len(t)):
        step = _both(lambda p, q: 0.5 * (t[i] - t[i - 1]) * (p + q), x[i - 1], x[i])
        out.append(_both(lambda p, q: p + q, out[-1], step))
    return out


def _lag(t, x, tau):
    out = [x[0]]
    for i in range(1, len(t)):
        step = t[i] - t[i - 1]
        keep = math.exp(-step / tau)
        slope = (step - tau * (1.0 - keep)) / step
        new = _both(lambda p, q: (1.0 - keep) * p + slope * (q - p), x[i - 1], x[i])
        out.append(_both(lambda p, q: keep * p + q, out[-1], new))
    return out


def _delay(t, x, s):
    return [_at(t, x, c - s) for c in t]


def _through(x, y, slope, at):
    at = min(max(at, x[0]), x[-1])
    k = 0
    while k < len(x) - 2 and at >= x[k + 1]:
        k += 1
    h = x[k + 1] - x[k]
    s = (at - x[k]) / h
    rest = 1.0 - s
    value = y[k] * (1.0 + 2.0 * s) * rest * rest + y[k + 1] * s * s * (3.0 - 2.0 * s)
    return value + h * (slope[k] * s * rest * rest - slope[k + 1] * s * s * rest)


def _play(t, x, width):
    out = [x[0]]
    for i in range(1, len(t)):
        out.append(_both(lambda y, c: min(max(y, c - 0.5 * width), c + 0.5 * width), out[-1], x[i]))
    return out

)";

class Python final : public Dialect {
 public:
  std::string row(const std::string& column, bool) const override {
    return column == "t_" ? "(t[i] - t[0])" : column + "[i]";
  }
  std::string axis(const std::string& column, std::size_t axis) const override {
    return fmt::format("{}[i][{}]", column, axis);
  }
  std::string call(const std::string& f, const std::vector<std::string>& a, bool vector) const override {
    if (f == "norm") return "_norm(" + a[0] + ")";
    if (f == "cross") return fmt::format("_cross({}, {})", a[0], a[1]);
    if (f == "step") return each(fmt::format("float(c > {})", a[1]), a[0], vector);
    if (f == "abs") return each("abs(c)", a[0], vector);
    if (f == "sign") return each("_sign(c)", a[0], vector);
    return each("math." + f + "(c)", a[0], vector);
  }
  std::string power(const std::string& a, const std::string& b, bool vector) const override {
    return vector ? each("c ** " + b, a, true) : fmt::format("({} ** {})", a, b);
  }
  std::string product(const std::string& a, const std::string& b, bool va, bool vb) const override {
    if (va && vb) return fmt::format("_v(lambda p, q: p * q, {}, {})", a, b);
    if (va) return fmt::format("[c * {} for c in {}]", b, a);
    if (vb) return fmt::format("[{} * c for c in {}]", a, b);
    return fmt::format("({} * {})", a, b);
  }
  std::string sum(const std::string& a, const std::string& b, char sign, bool vector) const override {
    return vector ? fmt::format("_v(lambda p, q: p {} q, {}, {})", sign, a, b) : fmt::format("({} {} {})", a, sign, b);
  }
  std::string column(const std::string& name, const std::string& helper, const std::string& inner,
                     const std::string& last, bool) const override {
    return fmt::format("    {} = _{}(t, [{} for i in range(len(t))]{})\n", name, helper, inner,
                       last.empty() ? "" : ", " + last);
  }
  std::string function(const Coupled& law, const std::string& name, const Names& drivers, const std::string& body,
                       const std::string& value) const override {
    std::string head = "t", comment;
    for (const auto& [driver, vector] : drivers) head += ", " + driver;
    for (const std::string& line : words(law, drivers)) comment += "    " + line + "\n";
    std::string loop = law.to_s > law.from_s ? fmt::format(
                                                   "        if not {} <= t[i] - t[0] <= {}:\n            "
                                                   "out.append([0.0, 0.0, 0.0])\n            continue\n",
                                                   number(law.from_s), number(law.to_s))
                                             : "";
    loop += "        x = " + value + "\n";
    if (law.table)
      loop += fmt::format("        out.append([_through(points, y[c], slope[c], {}) for c in range(3)])\n",
                          law.tree.vector ? "x[c]" : "x");
    else if (law.has_matrix)
      loop += fmt::format(
          "        matrix = [[{}], [{}], [{}]]\n        out.append([sum(r[j] * x[j] for j in range(3)) "
          "for r in matrix])\n",
          numbers(law, 0, 3), numbers(law, 3, 3), numbers(law, 6, 3));
    else
      loop += fmt::format("        out.append([k * c for k, c in zip([{}], {})])\n", numbers(law, 0, 3),
                          law.tree.vector ? "x" : "[x] * 3");
    return fmt::format(
        "{}\ndef {}({}):\n    \"\"\"\n{}    Vectors are lists of three numbers, one a row.\n"
        "    \"\"\"\n{}    out = []\n    for i in range(len(t)):\n{}    return out\n",
        kPythonHelpers, name, head, comment, body + (law.table ? points(*law.table) : ""), loop);
  }

 private:
  [[nodiscard]] std::string points(const Table& table) const {
    return fmt::format("    points = [{}]\n    y = {}\n    slope = {}\n", list(table.x), rows(table.y, '[', ']'),
                       rows(table.slope, '[', ']'));
  }

  static std::string each(const std::string& of_c, const std::string& a, bool vector) {
    return vector ? fmt::format("[{} for c in {}]", of_c, a) : fmt::format("(lambda c: {})({})", of_c, a);
  }
};

}  // namespace

const Dialect& python() {
  static const Python dialect;
  return dialect;
}

}  // namespace stillpoint::laws
