/// Every number of what the calibration has learnt, with name, unit and the range that it can have: one list for
/// writing, reading and checking (docs/formats.md).
#pragma once
#include <string>
#include <string_view>
#include <type_traits>

#include "calib_online/online_calibrator.h"

namespace stillpoint::calib {

/// What is given up together where one of its numbers cannot be.
enum class StatePart : std::uint8_t { kCommon, kAcc, kGyr, kGyrMatrix, kMag };
[[nodiscard]] constexpr std::string_view name(StatePart part) noexcept {
  constexpr std::string_view kNames[] = {"the times", "the accelerometer", "the gyroscope's bias",
                                         "the gyroscope's matrix", "the magnetometer"};
  return kNames[static_cast<std::size_t>(part)];
}

struct FieldOfState {
  StatePart part;
  std::string_view name, unit;
  Range range;
  int covariance = 0;  ///< rows of a symmetric matrix, kept as its lower triangle
};

namespace detail {

inline constexpr Range kCount = in_range(0.0, 4e9);
inline constexpr Range kVariance = in_range(-1e4, 1e4);

template <class V, class Attitudes>
void visit_attitudes(V& visit, StatePart part, std::string_view ups, std::string_view count, Attitudes& a) {
  visit({part, count, "-", in_range(0, Attitudes::kMost)}, a.count);
  for (auto& up : a.up) visit({part, ups, "-", in_range(-1.001, 1.001)}, up);
}

template <class V, class Sums>
void visit_sums(V& visit, std::string_view lower, std::string_view rhs, std::string_view segments, Sums& s) {
  constexpr Range kSums = in_range(-1e12, 1e12);
  visit({StatePart::kGyrMatrix, lower, "-", kSums}, s.lower);
  visit({StatePart::kGyrMatrix, rhs, "-", kSums}, s.rhs);
  visit({StatePart::kGyrMatrix, segments, "-", kCount}, s.segments);
}

}  // namespace detail

/// Calls visit(FieldOfState, member) for each, always in the same order. Members are numbers and arrays of them. Not
/// among them: what a restart ends, as the present attitude.
template <class State, class V>
void visit_state(State& s, V&& visit) {
  using detail::kCount, detail::kVariance;
  constexpr auto kAccPart = StatePart::kAcc, kGyrPart = StatePart::kGyr, kMatrix = StatePart::kGyrMatrix,
                 kMagPart = StatePart::kMag, kCommon = StatePart::kCommon;
  visit({kCommon, "snapshot_version", "-", in_range(0, 1e15)}, s.snapshot_version);
  visit({kCommon, "time", "ns", in_range(-9.2e18, 9.2e18)}, s.t_ns);
  visit({kCommon, "temperature.known", "-", in_range(0, 1)}, s.temperatures.known);
  visit({kCommon, "temperature.min", "degC", in_range(-273, 1000)}, s.temperatures.min_degC);
  visit({kCommon, "temperature.max", "degC", in_range(-273, 1000)}, s.temperatures.max_degC);

  visit({kAccPart, "acc.windows", "-", kCount}, s.acc.windows);
  visit({kAccPart, "acc.refused", "-", kCount}, s.acc.refused);
  visit({kAccPart, "acc.replaced", "-", in_range(0, 1)}, s.acc.replaced);
  visit({kAccPart, "acc.entries", "-", in_range(-100, 100)}, s.acc.published.x);
  visit({kAccPart, "acc.covariance", "-", kVariance, AccFilter::kStates}, s.acc.published.P.a);
  visit({kAccPart, "acc.rival.open", "-", in_range(0, 1)}, s.acc.rivalry.open);
  visit({kAccPart, "acc.rival.former", "-", in_range(0, 1)}, s.acc.rivalry.former);
  visit({kAccPart, "acc.rival.log_odds", "-", in_range(-15, 15)}, s.acc.rivalry.log_odds);
  detail::visit_attitudes(visit, kAccPart, "acc.rival.up", "acc.rival.attitudes", s.acc.rivalry.voted);
  visit({kAccPart, "acc.rival.entries", "-", in_range(-100, 100)}, s.acc.rival.x);
  visit({kAccPart, "acc.rival.covariance", "-", kVariance, AccFilter::kStates}, s.acc.rival.P.a);
  detail::visit_attitudes(visit, kAccPart, "acc.up", "acc.attitudes", s.acc.learnt_in);
  visit({kAccPart, "acc.noise.chi2", "-", in_range(0, 1e6)}, s.acc.noise.chi2);
  visit({kAccPart, "acc.noise.freedom", "-", in_range(0, 1e6)}, s.acc.noise.freedom);
  visit({kAccPart, "acc.error.factory", "-", in_range(0, 1e6)}, s.acc.factory_error);
  visit({kAccPart, "acc.error.learnt", "-", in_range(0, 1e6)}, s.acc.learnt_error);
  visit({kAccPart, "acc.error.weight", "-", in_range(0, 1e6)}, s.acc.error_weight);
  for (auto& cell : s.acc.cells) {
    auto sums = cell.sums.sums();
    visit({kAccPart, "acc.cell.sums", "-", in_range(-1e12, 1e12)}, sums);
    if constexpr (!std::is_const_v<State>) cell.sums = Moments::of(sums);
    visit({kAccPart, "acc.cell.temperature", "degC", in_range(-1e12, 1e12)}, cell.temp_sum);
  }

  visit({kGyrPart, "gyr.windows", "-", kCount}, s.gyr.published.windows);
  visit({kGyrPart, "gyr.refused", "-", kCount}, s.gyr.refused);
  visit({kGyrPart, "gyr.replaced", "-", in_range(0, 1)}, s.gyr.replaced);
  visit({kGyrPart, "gyr.bias", "rad/s", in_range(-35, 35)}, s.gyr.published.filter.x);
  visit({kGyrPart, "gyr.covariance", "rad2/s2", kVariance, GyrFilter::kStates}, s.gyr.published.filter.P.a);
  visit({kGyrPart, "gyr.rival.open", "-", in_range(0, 1)}, s.gyr.rivalry.open);
  visit({kGyrPart, "gyr.rival.former", "-", in_range(0, 1)}, s.gyr.rivalry.former);
  visit({kGyrPart, "gyr.rival.log_odds", "-", in_range(-15, 15)}, s.gyr.rivalry.log_odds);
  detail::visit_attitudes(visit, kGyrPart, "gyr.rival.up", "gyr.rival.attitudes", s.gyr.rivalry.voted);
  visit({kGyrPart, "gyr.rival.windows", "-", kCount}, s.gyr.rival.windows);
  visit({kGyrPart, "gyr.rival.bias", "rad/s", in_range(-35, 35)}, s.gyr.rival.filter.x);
  visit({kGyrPart, "gyr.rival.covariance", "rad2/s2", kVariance, GyrFilter::kStates}, s.gyr.rival.filter.P.a);
  detail::visit_attitudes(visit, kGyrPart, "gyr.up", "gyr.attitudes", s.gyr.seen);
  visit({kGyrPart, "gyr.noise.chi2", "-", in_range(0, 1e6)}, s.gyr.published.noise.chi2);
  visit({kGyrPart, "gyr.noise.freedom", "-", in_range(0, 1e6)}, s.gyr.published.noise.freedom);

  detail::visit_sums(visit, "gyr_matrix.information", "gyr_matrix.rhs", "gyr_matrix.turns", s.gyr_matrix.published);
  detail::visit_sums(visit, "gyr_matrix.rival.information", "gyr_matrix.rival.rhs", "gyr_matrix.rival.turns",
                     s.gyr_matrix.rival);
  visit({kMatrix, "gyr_matrix.rival.open", "-", in_range(0, 1)}, s.gyr_matrix.rivalry.open);
  visit({kMatrix, "gyr_matrix.rival.log_odds", "-", in_range(-15, 15)}, s.gyr_matrix.rivalry.log_odds);
  detail::visit_attitudes(visit, kMatrix, "gyr_matrix.rival.up", "gyr_matrix.rival.attitudes",
                          s.gyr_matrix.rivalry.voted);
  visit({kMatrix, "gyr_matrix.refused", "-", kCount}, s.gyr_matrix.refused);
  visit({kMatrix, "gyr_matrix.wide", "-", in_range(0, 2)}, s.gyr_matrix.wide);
  visit({kMatrix, "gyr_matrix.noise.chi2", "-", in_range(0, 1e6)}, s.gyr_matrix.noise.chi2);
  visit({kMatrix, "gyr_matrix.noise.freedom", "-", in_range(0, 1e6)}, s.gyr_matrix.noise.freedom);
  visit({kMatrix, "gyr_matrix.lately", "-", in_range(0, 1e9)}, s.gyr_matrix.lately);

  visit({kMagPart, "mag.time", "ns", in_range(-9.2e18, 9.2e18)}, s.mag.t_ns);
  visit({kMagPart, "mag.matrix_and_iron", "-,uT", in_range(-1e5, 1e5)}, s.mag.field.x);
  visit({kMagPart, "mag.covariance", "-,uT2", in_range(-1e9, 1e9), FieldFilter::kStates}, s.mag.field.P.a);
  visit({kMagPart, "mag.misfit", "uT2", in_range(0, 1e9)}, s.mag.field.misfit_uT2);
  visit({kMagPart, "mag.noise", "uT2", in_range(0, 1e9)}, s.mag.field.white_uT2);
  visit({kMagPart, "mag.strength", "uT", in_range(0, 1e5)}, s.mag.field.strength_uT);
  visit({kMagPart, "mag.error.factory", "uT2", in_range(0, 1e12)}, s.mag.field.factory_error);
  visit({kMagPart, "mag.error.learnt", "uT2", in_range(0, 1e12)}, s.mag.field.learnt_error);
  visit({kMagPart, "mag.turns", "-", kCount}, s.mag.field.pairs);
  visit({kMagPart, "mag.compared", "-", kCount}, s.mag.field.compared);
  visit({kMagPart, "mag.changes", "-", kCount}, s.mag.field.changes);
}

/// What is wrong with these numbers, in words; empty where nothing is.
[[nodiscard]] std::string fault_of(const FieldOfState& field, std::span<const double> values);
/// The first fault of all, empty where there is none.
[[nodiscard]] std::string fault_of(const OnlineCalibrator::State& state);

}  // namespace stillpoint::calib
