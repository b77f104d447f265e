#include "laws/unit.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>
#include <vector>

namespace stillpoint::laws {
namespace {

constexpr double kSame = 1e-9;  // of two powers

constexpr std::array<const char*, Unit::kBases> kSymbol{"m", "s", "rad", "K", "uT", "A", "V", "Pa", "unit"};

std::string power_text(std::size_t base, double power) {
  return std::abs(power - 1.0) < kSame ? kSymbol[base] : fmt::format("{}^{:g}", kSymbol[base], power);
}

}  // namespace

bool Unit::plain() const { return *this == Unit{}; }

Unit Unit::to_the(double exponent) const {
  Unit out = *this;
  for (double& p : out.power) p *= exponent;
  return out;
}

Unit operator*(const Unit& a, const Unit& b) {
  Unit out = a;
  for (std::size_t i = 0; i < Unit::kBases; ++i) out.power[i] += b.power[i];
  return out;
}

Unit operator/(const Unit& a, const Unit& b) { return a * b.to_the(-1.0); }

bool operator==(const Unit& a, const Unit& b) {
  for (std::size_t i = 0; i < Unit::kBases; ++i)
    if (std::abs(a.power[i] - b.power[i]) > kSame) return false;
  return true;
}

Unit Unit::of(Base base, double exponent) {
  Unit out;
  out.power[base] = exponent;
  return out;
}

std::string text(const Unit& unit) {
  std::string above, below;
  int divisors = 0;
  for (const std::size_t base : {Unit::kRadian, Unit::kMetre, Unit::kMicrotesla, Unit::kKelvin, Unit::kAmpere,
                                 Unit::kVolt, Unit::kPascal, Unit::kOther, Unit::kSecond}) {
    const double p = unit.power[base];
    if (p > kSame) above += (above.empty() ? "" : " ") + power_text(base, p);
    if (p < -kSame) below += (below.empty() ? "" : " ") + power_text(base, -p), ++divisors;
  }
  if (below.empty()) return above.empty() ? "1" : above;
  return (above.empty() ? "1" : above) + "/" + (divisors > 1 ? "(" + below + ")" : below);
}

Unit unit_of_column(std::string_view name) {
  using enum Unit::Base;
  static const std::vector<std::pair<std::string_view, Unit>> known{{"mps2", Unit::of(kMetre) / Unit::of(kSecond, 2.0)},
                                                                    {"mps", Unit::of(kMetre) / Unit::of(kSecond)},
                                                                    {"radps", Unit::of(kRadian) / Unit::of(kSecond)},
                                                                    {"rad", Unit::of(kRadian)},
                                                                    {"m", Unit::of(kMetre)},
                                                                    {"s", Unit::of(kSecond)},
                                                                    {"Hz", Unit::of(kSecond, -1.0)},
                                                                    {"degC", Unit::of(kKelvin)},
                                                                    {"K", Unit::of(kKelvin)},
                                                                    {"uT", Unit::of(kMicrotesla)},
                                                                    {"A", Unit::of(kAmpere)},
                                                                    {"V", Unit::of(kVolt)},
                                                                    {"Pa", Unit::of(kPascal)},
                                                                    {"1", Unit{}}};
  const std::size_t at = name.rfind('_');
  const std::string_view end = at == std::string_view::npos ? std::string_view{} : name.substr(at + 1);
  for (const auto& [symbol, unit] : known)
    if (end == symbol) return unit;
  return Unit::of(kOther);
}

}  // namespace stillpoint::laws
