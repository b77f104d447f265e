/// Effects that a file writes as a law or a table instead of taking them from the catalogue: `{effect: law, ...}` and
/// `{effect: table, ...}` of docs/formats.md.
#pragma once
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/result.h"
#include "laws/emit.h"
#include "laws/stream.h"
#include "simulation/config.h"

namespace stillpoint::sim {

/// The entry keeps its expression in the ID behind one of these, as findings do behind "unknown:". Its one sensor
/// stands in `sensors`; `k` or `matrix` and `tau_s`, or `x`, `y` (three rows) and `clamp` in `parameters`.
inline constexpr std::string_view kLawPrefix = "law:", kTablePrefix = "table:";

[[nodiscard]] bool is_law(const EffectConfig& e);
[[nodiscard]] bool is_table(const EffectConfig& e);
[[nodiscard]] std::string expression_of(const EffectConfig& e);

/// Standard drivers, and as user columns those names in the text that look like one (name_unit).
[[nodiscard]] laws::Signature signature_for(std::string_view expression);

/// The expression as the entry means it, tau_s included. Fails where it cannot be parsed.
[[nodiscard]] tl::expected<laws::Node, laws::Fault> tree_of(const EffectConfig& e);

/// The law or table with its numbers, for evaluation over columns and for emitting code. Pre: one of both, parses.
[[nodiscard]] laws::Coupled coupled(const EffectConfig& e);

/// Piecewise cubic through the points that never leaves the span of its neighbours (Fritsch and Carlson, "Monotone
/// Piecewise Cubic Interpolation", SIAM J. Numer. Anal. 17, 1980). Outside its range the end value.
class Curve {
 public:
  Curve(std::vector<double> x, std::vector<double> y);  ///< Pre: two points at least, x increasing
  [[nodiscard]] double at(double x) const noexcept;
  [[nodiscard]] bool covers(double x) const noexcept { return x >= x_.front() && x <= x_.back(); }
  [[nodiscard]] const std::vector<double>& values() const noexcept { return y_; }      ///< at the points
  [[nodiscard]] const std::vector<double>& slopes() const noexcept { return slope_; }  ///< at the points

 private:
  std::vector<double> x_, y_, slope_;
};

/// A table's three curves.
[[nodiscard]] std::array<Curve, 3> curves_of(const EffectConfig& table);

/// What an entry adds, row after row.
class LawEffect {
 public:
  explicit LawEffect(const EffectConfig& e);  ///< Pre: is_law or is_table, parses
  [[nodiscard]] Vec3 next(const laws::DriverAt& drivers, double t_s);
  /// Whether the last row's driver was outside the table's range, and no `clamp: true` allows it.
  [[nodiscard]] bool outside() const noexcept { return outside_; }

 private:
  laws::Stream stream_;
  Mat3 matrix_ = Mat3::Identity();
  std::vector<Curve> curves_;  ///< three, or none
  Vec3 axes_ = Vec3::Ones();
  double from_s_, to_s_;
  bool clamp_ = false, outside_ = false;
};

[[nodiscard]] std::vector<LawEffect> law_effects(const std::vector<EffectConfig>& effects, Sensor sensor);

/// Names of user columns that the laws and tables need.
[[nodiscard]] std::vector<std::string> user_columns_of(const std::vector<EffectConfig>& effects);

}  // namespace stillpoint::sim
