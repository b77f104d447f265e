#include "laws/expression.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "laws/words.h"

namespace stillpoint::laws {
namespace {

/// How tightly a node binds: what binds less than its surroundings gets brackets, and nothing else: a text nests no
/// deeper than the one it was read from, which is how deep the parser follows.
int binding(const Node& n) {
  switch (n.op) {
    case Op::kAdd:
    case Op::kSubtract:
      return 1;
    case Op::kMultiply:
    case Op::kDivide:
      return 2;
    case Op::kNegate:
      return 3;
    case Op::kNumber:
      return n.number < 0.0 ? 3 : 5;
    case Op::kPower:
      return 4;
    default:
      return 5;
  }
}

std::string bracketed(const Node& n, int least) { return binding(n) < least ? "(" + text(n) + ")" : text(n); }

std::string infix(const Node& n, const char* sign, int own) {
  return bracketed(n.args[0], own) + sign + bracketed(n.args[1], own + 1);
}

void collect(const Node& n, std::vector<std::string>& out) {
  if (!n.driver.empty() && std::find(out.begin(), out.end(), n.driver) == out.end()) out.push_back(n.driver);
  for (const Node& a : n.args) collect(a, out);
}

Unit metres_per(double seconds) { return Unit::of(Unit::kMetre) / Unit::of(Unit::kSecond, seconds); }

/// A driver told from a point in its midst. Nothing is chosen with that number: what another one would add is a bias or
/// a matrix.
bool is_from_reference(const Node& n) {
  static const std::set<std::string> known{"T - 25", "V - 3.7", "norm(f) - 9.81"};
  return n.op == Op::kSubtract && known.contains(text(n));
}

/// Adds the numbers of the text to `numbers`: one that stands there twice is said once.
double bits_of(const Node& n, std::set<std::string>& numbers) {
  // Words: 24 operations; a driver is one of the standard ones and its axes.
  if (is_from_reference(n)) return bits_of(n.args[0], numbers);
  const double word = std::log2(static_cast<double>(kFunctions.size() + 9));
  double bits = word;
  if (n.op == Op::kDriver || n.op == Op::kComponent) bits += std::log2(static_cast<double>(standard_drivers().size()));
  if (n.op == Op::kComponent) bits += std::log2(3.0);
  if (n.op == Op::kNumber && numbers.insert(text(n)).second)
    bits += std::log2(10.0) * static_cast<double>(text(n).size());
  for (const Node& a : n.args) bits += bits_of(a, numbers);
  return bits;
}

}  // namespace

const Signature& standard_drivers() {
  static const Signature all{
      {"w", {true, Unit::of(Unit::kRadian) / Unit::of(Unit::kSecond), "rate"}},
      {"f", {true, metres_per(2.0), "specific force"}},
      {"m", {true, Unit::of(Unit::kMicrotesla), "field"}},
      {"p", {true, Unit::of(Unit::kMetre), "position in the world"}},
      {"east", {true, Unit{}, "attitude"}},
      {"north", {true, Unit{}, "attitude"}},
      {"up", {true, Unit{}, "attitude"}},
      {"T", {false, Unit::of(Unit::kKelvin), "temperature"}},
      {"V", {false, Unit::of(Unit::kVolt), "supply voltage"}},
      {"I", {false, Unit::of(Unit::kAmpere), "current"}},
      {"t", {false, Unit::of(Unit::kSecond), "time since the start"}},
  };
  return all;
}

Signature drivers_with(const std::vector<std::string>& user_columns) {
  Signature out = standard_drivers();
  for (const std::string& name : user_columns) out.try_emplace(name, DriverInfo{false, unit_of_column(name), name});
  return out;
}

std::string text(const Node& n) {
  switch (n.op) {
    case Op::kNumber:
      return fmt::format("{}", n.number);
    case Op::kDriver:
      return n.driver;
    case Op::kComponent:
      return fmt::format("{}_{}", n.driver, "xyz"[n.component]);
    case Op::kNegate:
      return "-" + bracketed(n.args[0], 3);
    case Op::kAdd:
      return infix(n, " + ", 1);
    case Op::kSubtract:
      return infix(n, " - ", 1);
    case Op::kMultiply:
      return infix(n, " * ", 2);
    case Op::kDivide:
      return infix(n, " / ", 2);
    case Op::kPower:
      return bracketed(n.args[0], 5) + "^" + bracketed(n.args[1], 3);
    default:
      break;
  }
  std::string out(function_of(n.op)->name);
  for (std::size_t i = 0; i < n.args.size(); ++i) out += (i == 0 ? "(" : ", ") + text(n.args[i]);
  return out + ")";
}

std::vector<std::string> drivers_of(const Node& tree) {
  std::vector<std::string> out;
  collect(tree, out);
  return out;
}

bool memoryless(const Node& n) {
  if (n.op == Op::kRate || n.op == Op::kIntegral || n.op == Op::kLag || n.op == Op::kDelay || n.op == Op::kPlay)
    return false;
  return std::all_of(n.args.begin(), n.args.end(), [](const Node& a) { return memoryless(a); });
}

double complexity_bits(const Node& n) {
  std::set<std::string> numbers;
  return bits_of(n, numbers);
}

Node number(double value) {
  Node n;
  n.number = value;
  return n;
}

Node driver(std::string name) {
  Node n;
  n.op = Op::kDriver;
  n.driver = std::move(name);
  return n;
}

Node component(std::string name, std::size_t axis) {
  Node n = driver(std::move(name));
  n.op = Op::kComponent;
  n.component = axis;
  return n;
}

Node apply(Op op, std::vector<Node> args) {
  Node n;
  n.op = op;
  n.args = std::move(args);
  return n;
}

}  // namespace stillpoint::laws
