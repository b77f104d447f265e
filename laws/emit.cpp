/// One walk over the tree serves all languages: what has a history becomes a column of its own first, what looks at one
/// moment is an expression inside the loop over the rows.
#include "laws/emit.h"

#include <fmt/format.h>

#include <algorithm>

#include "laws/emit_language.h"
#include "laws/evaluate.h"
#include "laws/words.h"

namespace stillpoint::laws {
namespace {

class Writer {
 public:
  explicit Writer(const Dialect& dialect) : d_(dialect) {}

  /// The expression at row i; its columns with a history are written to body() before it.
  std::string at_row(const Node& n) {
    switch (n.op) {
      case Op::kNumber:
        return fmt::format("{}", d_.number(n.number));
      case Op::kDriver:
        return d_.row(n.driver == "t" ? "t_" : n.driver, n.vector);
      case Op::kComponent:
        return d_.axis(n.driver, n.component);
      case Op::kRate:
      case Op::kIntegral:
      case Op::kLag:
      case Op::kDelay:
      case Op::kPlay:
        return d_.row(column_of(n), n.vector);
      default:
        return operation(n);
    }
  }
  [[nodiscard]] const std::string& body() const { return body_; }

 private:
  std::string operation(const Node& n) {
    std::vector<std::string> args;
    for (const Node& a : n.args) args.push_back(at_row(a));
    if (n.op == Op::kPower) return d_.power(args[0], args[1], n.vector);
    if (const Function* f = function_of(n.op)) return d_.call(std::string(f->name), args, n.args[0].vector);
    if (n.op == Op::kNegate) return d_.product("-1.0", args[0], false, n.vector);
    const bool va = n.args[0].vector, vb = n.args[1].vector;
    if (n.op == Op::kMultiply) return d_.product(args[0], args[1], va, vb);
    if (n.op == Op::kDivide) return d_.product(args[0], d_.inverse(args[1]), va, false);
    return d_.sum(args[0], args[1], n.op == Op::kAdd ? '+' : '-', n.vector);
  }

  std::string column_of(const Node& n) {
    const std::string inner = at_row(n.args[0]);
    std::string name = fmt::format("c{}", ++columns_);
    std::string helper(function_of(n.op)->name), last;
    if (n.op == Op::kRate) helper = "rate", last = d_.number(rate_span_s(n));
    if (n.args.size() > 1) last = d_.number(n.args[1].number);
    body_ += d_.column(name, helper, inner, last, n.vector);
    return name;
  }

  const Dialect& d_;
  std::string body_;
  int columns_ = 0;
};

}  // namespace

const char* suffix(Language language) {
  return language == Language::kPython ? "py" : language == Language::kCpp ? "h" : "m";
}

std::string emit(const Coupled& law, const std::string& name, Language language) {
  const Dialect& dialect = dialect_of(language);
  Writer writer(dialect);
  const std::string value = writer.at_row(law.tree);
  std::vector<std::pair<std::string, bool>> drivers;
  for (const std::string& d : drivers_of(law.tree))
    if (d != "t") drivers.emplace_back(d, false);
  const auto mark_vectors = [&](const auto& self, const Node& n) -> void {
    for (auto& [driver_name, vector] : drivers)
      if (n.driver == driver_name) vector = vector || n.op == Op::kComponent || n.vector;
    for (const Node& a : n.args) self(self, a);
  };
  mark_vectors(mark_vectors, law.tree);
  return dialect.function(law, name, drivers, writer.body(), value);
}

}  // namespace stillpoint::laws
