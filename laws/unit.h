/// Units of drivers and laws: powers of the quantities that sensors meet. They are carried through every expression, so
/// that a coefficient has a unit and a sum of unlike things is refused.
#pragma once
#include <array>
#include <optional>
#include <string>
#include <string_view>

namespace stillpoint::laws {

struct Unit {
  enum Base : std::size_t { kMetre, kSecond, kRadian, kKelvin, kMicrotesla, kAmpere, kVolt, kPascal, kOther, kBases };
  std::array<double, kBases> power{};

  [[nodiscard]] bool plain() const;  ///< a pure number
  [[nodiscard]] Unit to_the(double exponent) const;
  friend Unit operator*(const Unit& a, const Unit& b);
  friend Unit operator/(const Unit& a, const Unit& b);
  /// Equal but for what rounding does to a power.
  friend bool operator==(const Unit& a, const Unit& b);

  static Unit of(Base base, double exponent = 1.0);
};

/// "rad/s K", "m/s^2", "1": numerator, then everything that divides.
[[nodiscard]] std::string text(const Unit& unit);

/// Unit of a user column from the end of its name: "motor_rpm" has rpm (a unit of its own kind), "pressure_Pa" Pa.
[[nodiscard]] Unit unit_of_column(std::string_view name);

}  // namespace stillpoint::laws
