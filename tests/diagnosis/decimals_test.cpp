/// What the digits of a file leave of a reference: fixed decimals, significant digits, single precision.
#include "diagnosis/reference/decimals.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <functional>

#include "diagnosis/reference/differences.h"

namespace stillpoint::diag {
namespace {

constexpr double kStep_s = 0.005;

double as_text(const char* format, double x) {
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), format, x);
  return std::strtod(text.data(), nullptr);
}

/// Metres of a vehicle, written in some way; and the error of that, per row.
double acceleration_noise(const std::function<double(double)>& written, double& error_sd) {
  io::Recording r;
  double square = 0.0;
  for (int i = 0; i < 4000; ++i) {
    const double t = kStep_s * i, x = 6.0 * std::sin(0.7 * t) + 0.3 * std::sin(5.0 * t);
    r.t_ns.push_back(std::llround(1e9 * t));
    r.ref_position_m.emplace_back(written(x), 0.0, 0.0);
    r.ref_q_world_body.emplace_back(1.0, 0.0, 0.0, 0.0);
    square += std::pow(written(x) - x, 2);
  }
  error_sd = std::sqrt(square / 4000.0);
  return rounding_noise(r, kStep_s).acceleration_mps2;
}

TEST(RoundingNoise, IsThatOfHowTheFileWasWritten) {
  const std::vector<std::pair<const char*, std::function<double(double)>>> writers{
      {"six decimals", [](double x) { return as_text("%.6f", x); }},
      {"eight digits", [](double x) { return as_text("%.8g", x); }},
      {"single precision", [](double x) { return static_cast<double>(static_cast<float>(x)); }},
      {"single precision in text", [](double x) { return as_text("%.9g", static_cast<float>(x)); }}};
  for (const auto& [name, written] : writers) {
    double sd = 0.0;
    const double noise = acceleration_noise(written, sd);
    EXPECT_NEAR(noise, noise_of_second_derivative(sd, kStep_s), 0.1 * noise) << name << ", error " << sd;
  }
  double sd = 0.0;
  EXPECT_LT(acceleration_noise([](double x) { return x; }, sd), 1e-6) << "all digits that there are";
}

}  // namespace
}  // namespace stillpoint::diag
