#include <fmt/format.h>

#include "laws/emit_language.h"

namespace stillpoint::laws {
namespace {

constexpr const char* kMatlabHelpers = R"(
function y = at_(t, x, s)
  s = min(max(s, t(1)), t(end));
  y = interp1(t, x, s);
end

function y = rate_(t, x, span)
  n = numel(t);
  if span > 0
    a = max(t - span, t(1)); b = min(t + span, t(n));
    y = (at_(t, x, b) - at_(t, x, a)) ./ (b - a);
  else
    j = max((1:n)' - 1, 1); k = min((1:n)' + 1, n);
    y = (x(k, :) - x(j, :)) ./ (t(k) - t(j));
  end
end

function y = integral_(t, x)
  y = zeros(size(x));
  for i = 2:numel(t)
    y(i, :) = y(i - 1, :) + 0.5 * (t(i) - t(i - 1)) * (x(i, :) + x(i - 1, :));
  end
end

function y = lag_(t, x, tau)
  y = x;
  for i = 2:numel(t)
    step = t(i) - t(i - 1); keep = exp(-step / tau); slope = (step - tau * (1 - keep)) / step;
    y(i, :) = keep * y(i - 1, :) + (1 - keep) * x(i - 1, :) + slope * (x(i, :) - x(i - 1, :));
  end
end

function y = delay_(t, x, s)
  y = at_(t, x, t - s);
end

function v = through_(x, y, slope, at)
  at = min(max(at, x(1)), x(end));
  k = ones(size(at));
  for j = 2:numel(x) - 1
    k(at >= x(j)) = j;
  end
  h = reshape(x(k + 1) - x(k), size(at)); s = (at - reshape(x(k), size(at))) ./ h; rest = 1 - s;
  of = @(values) reshape(values, size(at));
  v = of(y(k)) .* (1 + 2 * s) .* rest .^ 2 + of(y(k + 1)) .* s .^ 2 .* (3 - 2 * s);
  v = v + h .* (of(slope(k)) .* s .* rest .^ 2 - of(slope(k + 1)) .* s .^ 2 .* rest);
end

function y = play_(t, x, width)
  y = x;
  for i = 2:numel(t)
    y(i, :) = min(max(y(i - 1, :), x(i, :) - 0.5 * width), x(i, :) + 0.5 * width);
  end
end
)";

/// Whole columns at once: MATLAB needs no loop over the rows.
class Matlab final : public Dialect {
 public:
  std::string row(const std::string& column, bool) const override { return column == "t_" ? "(t - t(1))" : column; }
  std::string axis(const std::string& column, std::size_t axis) const override {
    return fmt::format("{}(:, {})", column, axis + 1);
  }
  std::string call(const std::string& f, const std::vector<std::string>& a, bool) const override {
    if (f == "norm") return fmt::format("sqrt(sum(({}) .^ 2, 2))", a[0]);
    if (f == "cross") return fmt::format("cross({}, {}, 2)", a[0], a[1]);
    if (f == "step") return fmt::format("double({} > {})", a[0], a[1]);
    return fmt::format("{}({})", f, a[0]);
  }
  std::string power(const std::string& a, const std::string& b, bool) const override {
    return fmt::format("(({}) .^ {})", a, b);
  }
  std::string product(const std::string& a, const std::string& b, bool, bool) const override {
    return fmt::format("({} .* {})", a, elementwise(b));
  }
  std::string sum(const std::string& a, const std::string& b, char sign, bool) const override {
    return fmt::format("({} {} {})", a, sign, b);
  }
  std::string column(const std::string& name, const std::string& helper, const std::string& inner,
                     const std::string& last, bool) const override {
    return fmt::format("  {} = {}_(t, {} + zeros(size(t)){});\n", name, helper, inner, last.empty() ? "" : ", " + last);
  }
  std::string function(const Coupled& law, const std::string& name, const Names& drivers, const std::string& body,
                       const std::string& value) const override {
    std::string head = "t", comment;
    for (const auto& [driver, vector] : drivers) head += ", " + driver;
    for (const std::string& line : words(law, drivers)) comment += "% " + line + "\n";
    const std::string coefficients = law.table        ? through(*law.table, law.tree.vector)
                                     : law.has_matrix ? fmt::format("  out = x * [{}; {}; {}]';\n", numbers(law, 0, 3),
                                                                    numbers(law, 3, 3), numbers(law, 6, 3))
                                                      : fmt::format("  out = x .* [{}];\n", numbers(law, 0, 3));
    const std::string window = law.to_s > law.from_s ? fmt::format("  s = t - t(1);\n  out(s < {} | s > {}, :) = 0;\n",
                                                                   number(law.from_s), number(law.to_s))
                                                     : "";
    return fmt::format(
        "function out = {}({})\n{}% Columns: t is n x 1, vectors are n x 3, one row a sample.\n{}  x = {} + "
        "zeros(size(t));\n{}{}end\n{}",
        name, head, comment, body, value, coefficients, window, kMatlabHelpers);
  }

 private:
  [[nodiscard]] std::string through(const Table& table, bool vector) const {
    std::string out = fmt::format("  points = [{}];\n  out = zeros(numel(t), 3);\n", list(table.x));
    for (std::size_t c = 0; c < 3; ++c)
      out += fmt::format("  out(:, {}) = through_(points, [{}], [{}], x(:, {}));\n", c + 1, list(table.y[c]),
                         list(table.slope[c]), vector ? c + 1 : 1);
    return out;
  }

  /// "(1.0 / x)" of the shared walk is a division of columns here.
  static std::string elementwise(std::string b) {
    if (b.rfind("(1.0 / ", 0) == 0) b.replace(0, 7, "(1.0 ./ ");
    return b;
  }
};

}  // namespace

const Dialect& matlab() {
  static const Matlab dialect;
  return dialect;
}

}  // namespace stillpoint::laws
