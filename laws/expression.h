/// A law's expression: a closed grammar over drivers, so that physics can be written in a file, searched for, run by
/// the simulator and emitted as code. Nothing of a file is ever executed.
#pragma once
#include <cstddef>
#include <map>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "laws/unit.h"

namespace stillpoint::laws {

enum class Op {
  kNumber,
  kDriver,
  kComponent,  ///< one axis of a vector driver: f_x
  kNegate,
  kAdd,
  kSubtract,
  kMultiply,  ///< of two vectors: axis by axis
  kDivide,
  kPower,  ///< by a number
  kNorm,
  kAbs,
  kSign,
  kExp,
  kLog,
  kSin,
  kCos,
  kTanh,  ///< saturates smoothly
  kCross,
  kStep,      ///< 1 where the first is above the second, a number, else 0
  kRate,      ///< d(x): time derivative
  kIntegral,  ///< from the start
  kLag,       ///< first-order low-pass, settled at the start
  kDelay,
  kPlay,  ///< backlash of a full width: follows when pushed by half of it
};

struct Node {
  Op op = Op::kNumber;
  double number = 0.0;  ///< of a kNumber
  std::string driver;   ///< of a kDriver or kComponent
  std::size_t component = 0;
  std::vector<Node> args;
  bool vector = false;
  Unit unit{};
  std::size_t column = 0;  ///< in the text it was parsed from, counted from 1
};

struct DriverInfo {
  bool vector = false;
  Unit unit;
  std::string words;  ///< "rate"
};

/// Drivers by name. The standard ones are w f m p (rate, force, field, position), T V I t, and east north up, the
/// world's axes seen from the sensor.
using Signature = std::map<std::string, DriverInfo, std::less<>>;
[[nodiscard]] const Signature& standard_drivers();
/// The standard drivers and user columns; a column's unit is the end of its name.
[[nodiscard]] Signature drivers_with(const std::vector<std::string>& user_columns);

struct Fault {
  std::size_t column = 0;
  std::string what;
};

/// Parses, resolves drivers and checks units. The fault says where, what, and what to do.
[[nodiscard]] tl::expected<Node, Fault> parse(std::string_view text, const Signature& drivers);

/// Fills in `vector` and `unit` of a tree built by hand. Pre: its drivers are in the signature.
[[nodiscard]] tl::expected<Node, Fault> checked(Node tree, const Signature& drivers);

/// Reads back to the same tree.
[[nodiscard]] std::string text(const Node& tree);

/// Names of the drivers in the order of the text, each once.
[[nodiscard]] std::vector<std::string> drivers_of(const Node& tree);

/// Whether the value depends on time only through drivers at that very time.
[[nodiscard]] bool memoryless(const Node& tree);

/// Description length: each node a choice among the grammar's words, each number to the digits it is written with.
[[nodiscard]] double complexity_bits(const Node& tree);

// Trees by hand.
[[nodiscard]] Node number(double value);
[[nodiscard]] Node driver(std::string name);
[[nodiscard]] Node component(std::string name, std::size_t axis);
[[nodiscard]] Node apply(Op op, std::vector<Node> args);

}  // namespace stillpoint::laws
