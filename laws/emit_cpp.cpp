#include <fmt/format.h>

#include "laws/emit_language.h"

namespace stillpoint::laws {
namespace {

constexpr const char* kCppHelpers = R"(#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

namespace {name}_law {
using V3 = std::array<double, 3>;
template <class F>
V3 each(const V3& a, F f) { return {f(a[0]), f(a[1]), f(a[2])}; }
template <class F>
double each(double a, F f) { return f(a); }
template <class F>
V3 both(const V3& a, const V3& b, F f) { return {f(a[0], b[0]), f(a[1], b[1]), f(a[2], b[2])}; }
template <class F>
double both(double a, double b, F f) { return f(a, b); }
inline V3 scale(double s, const V3& a) { return {s * a[0], s * a[1], s * a[2]}; }
inline double norm(const V3& a) { return std::sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]); }
inline V3 cross(const V3& a, const V3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline double sign(double x) { return static_cast<double>((x > 0) - (x < 0)); }
using Times = std::vector<double>;
template <class X>
X at(const Times& t, const std::vector<X>& x, double s) {
  s = std::clamp(s, t.front(), t.back());
  if (t.size() == 1) return x[0];
  std::size_t k = static_cast<std::size_t>(std::upper_bound(t.begin(), t.end(), s) - t.begin());
  k = std::min(std::max<std::size_t>(k, 1), t.size() - 1);
  const double share = (s - t[k - 1]) / (t[k] - t[k - 1]);
  return both(x[k - 1], x[k], [&](double p, double q) { return (1.0 - share) * p + share * q; });
}
template <class X>
std::vector<X> rate(const Times& t, const std::vector<X>& x, double span) {
  std::vector<X> out;
  for (std::size_t i = 0; i < t.size(); ++i) {
    const std::size_t j = i > 0 ? i - 1 : 0, k = std::min(i + 1, t.size() - 1);
    const double a = span > 0 ? std::max(t[i] - span, t.front()) : t[j];
    const double b = span > 0 ? std::min(t[i] + span, t.back()) : t[k];
    const X before = span > 0 ? at(t, x, a) : x[j], after = span > 0 ? at(t, x, b) : x[k];
    out.push_back(both(before, after, [&](double p, double q) { return (q - p) / (b - a); }));
  }
  return out;
}
template <class X>
std::vector<X> integral(const Times& t, const std::vector<X>& x) {
  std::vector<X> out{each(x[0], [](double) { return 0.0; })};
  for (std::size_t i = 1; i < t.size(); ++i) {
    const X step = both(x[i - 1], x[i], [&](double p, double q) { return 0.5 * (t[i] - t[i - 1]) * (p + q); });
    out.push_back(both(out.back(), step, [](double p, double q) { return p + q; }));
  }
  return out;
}
template <class X>
std::vector<X> lag(const Times& t, const std::vector<X>& x, double tau) {
  std::vector<X> out{x[0]};
  for (std::size_t i = 1; i < t.size(); ++i) {
    const double step = t[i] - t[i - 1], keep = std::exp(-step / tau), slope = (step - tau * (1.0 - keep)) / step;
    const X in = both(x[i - 1], x[i], [&](double p, double q) { return (1.0 - keep) * p + slope * (q - p); });
    out.push_back(both(out.back(), in, [&](double p, double q) { return keep * p + q; }));
  }
  return out;
}
template <class X>
std::vector<X> delay(const Times& t, const std::vector<X>& x, double s) {
  std::vector<X> out;
  for (const double c : t) out.push_back(at(t, x, c - s));
  return out;
}
template <class X>
std::vector<X> play(const Times& t, const std::vector<X>& x, double width) {
  std::vector<X> out{x[0]};
  for (std::size_t i = 1; i < t.size(); ++i)
    out.push_back(both(out.back(), x[i], [&](double y, double c) {
      return std::min(std::max(y, c - 0.5 * width), c + 0.5 * width);
    }));
  return out;
}
inline double through(const std::vector<double>& x, const std::vector<double>& y, const std::vector<double>& slope,
                      double at) {
  at = std::clamp(at, x.front(), x.back());
  std::size_t k = 0;
  while (k + 2 < x.size() && at >= x[k + 1]) ++k;
  const double h = x[k + 1] - x[k], s = (at - x[k]) / h, rest = 1.0 - s;
  const double value = y[k] * (1.0 + 2.0 * s) * rest * rest + y[k + 1] * s * s * (3.0 - 2.0 * s);
  return value + h * (slope[k] * s * rest * rest - slope[k + 1] * s * s * rest);
}
}  // namespace {name}_law

)";

std::string replaced(std::string text, const std::string& mark, const std::string& word) {
  for (std::size_t at = text.find(mark); at != std::string::npos; at = text.find(mark, at + word.size()))
    text.replace(at, mark.size(), word);
  return text;
}

class Cpp final : public Dialect {
 public:
  std::string row(const std::string& column, bool) const override {
    return column == "t_" ? "(t[i] - t[0])" : column + "[i]";
  }
  std::string axis(const std::string& column, std::size_t axis) const override {
    return fmt::format("{}[i][{}]", column, axis);
  }
  std::string call(const std::string& f, const std::vector<std::string>& a, bool) const override {
    if (f == "norm") return "norm(" + a[0] + ")";
    if (f == "cross") return fmt::format("cross({}, {})", a[0], a[1]);
    const std::string of_c = f == "step"   ? fmt::format("c > {} ? 1.0 : 0.0", a[1])
                             : f == "sign" ? std::string("sign(c)")
                                           : "std::" + f + "(c)";
    return fmt::format("each({}, [&](double c) {{ return {}; }})", a[0], of_c);
  }
  std::string power(const std::string& a, const std::string& b, bool) const override {
    return fmt::format("each({}, [&](double c) {{ return std::pow(c, {}); }})", a, b);
  }
  std::string product(const std::string& a, const std::string& b, bool va, bool vb) const override {
    if (va && vb) return fmt::format("both({}, {}, [](double p, double q) {{ return p * q; }})", a, b);
    if (va) return fmt::format("scale({}, {})", b, a);
    if (vb) return fmt::format("scale({}, {})", a, b);
    return fmt::format("({} * {})", a, b);
  }
  std::string sum(const std::string& a, const std::string& b, char sign, bool vector) const override {
    return vector ? fmt::format("both({}, {}, [](double p, double q) {{ return p {} q; }})", a, b, sign)
                  : fmt::format("({} {} {})", a, sign, b);
  }
  std::string column(const std::string& name, const std::string& helper, const std::string& inner,
                     const std::string& last, bool vector) const override {
    const std::string type = vector ? "std::vector<V3>" : "std::vector<double>";
    return fmt::format(
        "  {0} {1}(t.size());\n  for (std::size_t i = 0; i < t.size(); ++i) {1}[i] = {2};\n  {1} = {3}(t, "
        "{1}{4});\n",
        type, name, inner, helper, last.empty() ? "" : ", " + last);
  }
  std::string function(const Coupled& law, const std::string& name, const Names& drivers, const std::string& body,
                       const std::string& value) const override {
    std::string head = "const std::vector<double>& t", comment;
    for (const auto& [driver, vector] : drivers)
      head += fmt::format(", const std::vector<{}>& {}", vector ? "std::array<double, 3>" : "double", driver);
    for (const std::string& line : words(law, drivers)) comment += "// " + line + "\n";
    std::string loop = law.to_s > law.from_s ? fmt::format("    if (t[i] - t[0] < {} || t[i] - t[0] > {}) continue;\n",
                                                           number(law.from_s), number(law.to_s))
                                             : "";
    loop += fmt::format("    const {} x = {};\n", law.tree.vector ? "V3" : "double", value);
    if (law.table)
      loop += fmt::format("    for (std::size_t r = 0; r < 3; ++r) out[i][r] = through(points, y[r], slope[r], {});\n",
                          law.tree.vector ? "x[r]" : "x");
    else if (law.has_matrix)
      loop += fmt::format(
          "    const double matrix[3][3] = {{{{{}}}, {{{}}}, {{{}}}}};\n    for (std::size_t r = 0; r < 3; "
          "++r) out[i][r] = matrix[r][0] * x[0] + matrix[r][1] * x[1] + matrix[r][2] * x[2];\n",
          numbers(law, 0, 3), numbers(law, 3, 3), numbers(law, 6, 3));
    else
      loop += fmt::format(
          "    const double k[3] = {{{}}};\n    for (std::size_t r = 0; r < 3; ++r) out[i][r] = k[r] * {};\n",
          numbers(law, 0, 3), law.tree.vector ? "x[r]" : "x");
    return replaced(kCppHelpers, "{name}", name) + comment +
           fmt::format(
               "inline std::vector<std::array<double, 3>> {0}({1}) {{\n  using namespace {0}_law;\n{2}  "
               "std::vector<std::array<double, 3>> out(t.size(), {{0.0, 0.0, 0.0}});\n  for (std::size_t i = 0; "
               "i < t.size(); ++i) {{\n{3}  }}\n  return out;\n}}\n",
               name, head, body + (law.table ? points(*law.table) : ""), loop);
  }

 private:
  [[nodiscard]] std::string points(const Table& table) const {
    return fmt::format(
        "  const std::vector<double> points{{{}}};\n  const std::vector<double> y[3] = {};\n"
        "  const std::vector<double> slope[3] = {};\n",
        list(table.x), rows(table.y, '{', '}'), rows(table.slope, '{', '}'));
  }
};

}  // namespace

const Dialect& cpp() {
  static const Cpp dialect;
  return dialect;
}

}  // namespace stillpoint::laws
