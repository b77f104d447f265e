/// How one language writes the pieces of a law. Rows are `i`; vectors have three components.
#pragma once
#include <string>
#include <utility>
#include <vector>

#include "laws/emit.h"

namespace stillpoint::laws {

class Dialect {
 public:
  using Names = std::vector<std::pair<std::string, bool>>;  ///< drivers, and whether each is a vector

  virtual ~Dialect() = default;
  [[nodiscard]] virtual std::string row(const std::string& column, bool vector) const = 0;
  [[nodiscard]] virtual std::string axis(const std::string& column, std::size_t axis) const = 0;
  [[nodiscard]] virtual std::string call(const std::string& function, const std::vector<std::string>& args,
                                         bool vector) const = 0;
  [[nodiscard]] virtual std::string power(const std::string& a, const std::string& b, bool vector) const = 0;
  [[nodiscard]] virtual std::string product(const std::string& a, const std::string& b, bool va, bool vb) const = 0;
  [[nodiscard]] virtual std::string sum(const std::string& a, const std::string& b, char sign, bool vector) const = 0;
  /// A statement that makes `name` the helper's column of the expression `inner`; `last`: its number, or empty.
  [[nodiscard]] virtual std::string column(const std::string& name, const std::string& helper, const std::string& inner,
                                           const std::string& last, bool vector) const = 0;
  [[nodiscard]] virtual std::string function(const Coupled& law, const std::string& name, const Names& drivers,
                                             const std::string& body, const std::string& value) const = 0;

  [[nodiscard]] std::string number(double x) const;
  [[nodiscard]] std::string inverse(const std::string& a) const { return "(1.0 / " + a + ")"; }
  /// "1.0, 2.0, 3.0": `count` numbers from `first` on.
  [[nodiscard]] std::string numbers(const Coupled& law, std::size_t first, std::size_t count) const;
  /// "1.0, 2.0, 3.0"
  [[nodiscard]] std::string list(const std::vector<double>& values) const;
  /// Three such lists within these brackets.
  [[nodiscard]] std::string rows(const std::array<std::vector<double>, 3>& values, char open, char close) const;
  /// What stands above the function, one line each.
  [[nodiscard]] std::vector<std::string> words(const Coupled& law, const Names& drivers) const;
};

[[nodiscard]] const Dialect& python();
[[nodiscard]] const Dialect& cpp();
[[nodiscard]] const Dialect& matlab();

[[nodiscard]] inline const Dialect& dialect_of(Language l) {
  return l == Language::kPython ? python() : l == Language::kCpp ? cpp() : matlab();
}

}  // namespace stillpoint::laws
