/// Recursive descent: sum of products of powers of atoms.
#include <fmt/format.h>

#include <cctype>
#include <charconv>
#include <cmath>

#include "laws/expression.h"
#include "laws/words.h"

namespace stillpoint::laws {
namespace {

constexpr std::size_t kLongest = 2000;  // characters of a law
constexpr int kDeepest = 60;

using Parsed = tl::expected<Node, Fault>;

class Parser {
 public:
  Parser(std::string_view text, const Signature& drivers) : text_(text), drivers_(drivers) {}

  Parsed all() {
    if (text_.size() > kLongest) return fault(1, fmt::format("a law has at most {} characters", kLongest));
    Parsed tree = sum();
    if (!tree) return tree;
    skip();
    if (at_ < text_.size())
      return fault(at_ + 1, fmt::format("'{}' is not expected here; an operator is one of + - * / ^", text_[at_]));
    return tree;
  }

 private:
  static tl::unexpected<Fault> fault(std::size_t column, std::string what) {
    return tl::unexpected(Fault{column, std::move(what)});
  }
  void skip() {
    while (at_ < text_.size() && (text_[at_] == ' ' || text_[at_] == '\t')) ++at_;
  }
  bool take(char c) {
    skip();
    if (at_ >= text_.size() || text_[at_] != c) return false;
    ++at_;
    return true;
  }

  Parsed joined(Parsed (Parser::*part)(), char first, Op first_op, char second, Op second_op) {
    Parsed left = (this->*part)();
    while (left) {
      skip();
      const std::size_t column = at_ + 1;
      const bool is_first = take(first);
      if (!is_first && !take(second)) break;
      Parsed right = (this->*part)();
      if (!right) return right;
      *left = apply(is_first ? first_op : second_op, {std::move(*left), std::move(*right)});
      left->column = column;
    }
    return left;
  }
  Parsed sum() { return joined(&Parser::product, '+', Op::kAdd, '-', Op::kSubtract); }
  Parsed product() { return joined(&Parser::signed_power, '*', Op::kMultiply, '/', Op::kDivide); }

  Parsed signed_power() {
    skip();
    const std::size_t column = at_ + 1;
    if (++depth_ > kDeepest) return fault(column, "nested too deeply; write a simpler law");
    Parsed out = take('-') ? signed_power() : power();
    --depth_;
    if (!out || column > text_.size() || text_[column - 1] != '-') return out;
    // -3 is a number, so that a text reads back to the same tree.
    Node negated = out->op == Op::kNumber ? number(-out->number) : apply(Op::kNegate, {std::move(*out)});
    negated.column = column;
    return negated;
  }

  Parsed power() {
    Parsed base = atom();
    skip();
    const std::size_t column = at_ + 1;
    if (!base || !take('^')) return base;
    Parsed exponent = signed_power();
    if (!exponent) return exponent;
    Node out = apply(Op::kPower, {std::move(*base), std::move(*exponent)});
    out.column = column;
    return out;
  }

  Parsed atom() {
    skip();
    const std::size_t column = at_ + 1;
    if (at_ >= text_.size()) return fault(column, "the law ends where a driver, a number or '(' is due");
    const auto c = static_cast<unsigned char>(text_[at_]);
    if (take('(')) {
      Parsed inner = sum();
      if (!inner) return inner;
      if (!take(')')) return fault(at_ + 1, fmt::format("')' is missing for the '(' at column {}", column));
      return inner;
    }
    if (std::isdigit(c) != 0 || c == '.') return numeral(column);
    if (std::isalpha(c) != 0 || c == '_') return word(column);
    return fault(column, fmt::format("'{}' is not expected here; a driver, a number or '(' is due",
                                     std::isprint(c) != 0 ? text_[at_] : '?'));
  }

  Parsed numeral(std::size_t column) {
    double value = 0.0;
    const auto [end, error] = std::from_chars(text_.data() + at_, text_.data() + text_.size(), value);
    if (error != std::errc{} || !std::isfinite(value)) return fault(column, "not a number that can be used");
    at_ = static_cast<std::size_t>(end - text_.data());
    Node out = number(value);
    out.column = column;
    return out;
  }

  Parsed word(std::size_t column) {
    const std::size_t begin = at_;
    while (at_ < text_.size() && (std::isalnum(static_cast<unsigned char>(text_[at_])) != 0 || text_[at_] == '_'))
      ++at_;
    const std::string name(text_.substr(begin, at_ - begin));
    if (take('(')) return call(name, column);
    Node out;
    if (drivers_.contains(name)) {
      out = driver(name);
    } else if (name.size() > 2 && name[name.size() - 2] == '_' && name.back() >= 'x' && name.back() <= 'z' &&
               drivers_.contains(name.substr(0, name.size() - 2))) {
      out = component(name.substr(0, name.size() - 2), static_cast<std::size_t>(name.back() - 'x'));
    } else {
      return unknown(name, column);
    }
    out.column = column;
    return out;
  }

  [[nodiscard]] tl::unexpected<Fault> unknown(const std::string& name, std::size_t column) const {
    std::string known;
    for (const auto& [driver_name, info] : drivers_) known += (known.empty() ? "" : ", ") + driver_name;
    return fault(column, fmt::format("unknown driver '{}'; known here: {} (one axis of a vector: f_x)", name, known));
  }

  Parsed call(const std::string& name, std::size_t column) {
    const Function* function = nullptr;
    std::string known;
    for (const Function& f : kFunctions) {
      if (f.name == name) function = &f;
      known += (known.empty() ? "" : ", ") + std::string(f.name);
    }
    if (function == nullptr) return fault(column, fmt::format("unknown function '{}'; known: {}", name, known));
    std::vector<Node> args;
    do {
      Parsed arg = sum();
      if (!arg) return arg;
      args.push_back(std::move(*arg));
    } while (take(','));
    if (!take(')')) return fault(at_ + 1, fmt::format("')' is missing for {}( at column {}", name, column));
    if (args.size() != function->args)
      return fault(column, fmt::format("{} takes {} argument{}, as in {}", name, function->args,
                                       function->args == 1 ? "" : "s", function->example));
    Node out = apply(function->op, std::move(args));
    out.column = column;
    return out;
  }

  std::string_view text_;
  const Signature& drivers_;
  std::size_t at_ = 0;
  int depth_ = 0;
};

}  // namespace

tl::expected<Node, Fault> parse(std::string_view text, const Signature& drivers) {
  auto tree = Parser(text, drivers).all();
  if (!tree) return tree;
  return checked(std::move(*tree), drivers);
}

}  // namespace stillpoint::laws
