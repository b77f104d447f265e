/// How a fit ended.
#pragma once
#include <cstdint>
#include <string_view>

namespace stillpoint::calib {

enum class FitStatus : std::uint8_t {
  kOk,
  kTooFewPoints,
  kNotObservable,
  kNotPositiveDefinite,
  kNotConverged,
  kBadInput
};
[[nodiscard]] constexpr std::string_view name(FitStatus status) noexcept {
  switch (status) {
    case FitStatus::kOk:
      return "ok";
    case FitStatus::kTooFewPoints:
      return "too_few_points";
    case FitStatus::kNotObservable:
      return "not_observable";
    case FitStatus::kNotPositiveDefinite:
      return "not_positive_definite";
    case FitStatus::kNotConverged:
      return "not_converged";
    case FitStatus::kBadInput:
      return "bad_input";
  }
  return "?";
}

}  // namespace stillpoint::calib
