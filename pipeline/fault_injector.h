/// Any source behind faults that real sensors, buses and clocks show. Seeded: the same seed gives the same faults.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include "core/fields.h"
#include "pipeline/stage.h"

namespace stillpoint::pipeline {

/// Probabilities are per sample.
struct FaultParams {
  double drop = 0.0;
  double duplicate = 0.0;
  double not_finite = 0.0;
  double saturate = 0.0;
  double saturate_limit = 1e3;
  double stall = 0.0;
  double stall_s = 1.0;
  double clock_step = 0.0;
  double clock_step_s = -10.0;
  double garbage = 0.0;
  int seed = 1;

  template <class P = FaultParams>
  static constexpr auto fields() {
    return std::tuple{
        field("drop", &P::drop, in_range(0, 1), "probability that a sample is lost"),
        field("duplicate", &P::duplicate, in_range(0, 1), "probability that a sample comes twice"),
        field("not_finite", &P::not_finite, in_range(0, 1), "probability that an axis reads NaN or infinity"),
        field("saturate", &P::saturate, in_range(0, 1), "probability that an axis sits at the limit"),
        field("saturate_limit", &P::saturate_limit, positive(), "that limit, in the unit of the reading"),
        field("stall", &P::stall, in_range(0, 1), "probability that the stream pauses, samples lost meanwhile"),
        field("stall_s", &P::stall_s, in_range(0, 3600), "length of a pause in the sensor's time"),
        field("clock_step", &P::clock_step, in_range(0, 1), "probability that the sensor's clock is set"),
        field("clock_step_s", &P::clock_step_s, in_range(-1e9, 1e9), "by how much"),
        field("garbage", &P::garbage, in_range(0, 1), "probability that a triad is a broken transfer, up to 1e300"),
        field("seed", &P::seed, in_range(0, 2e9), "of the random stream")};
  }
  [[nodiscard]] bool any() const noexcept {
    return std::max({drop, duplicate, not_finite, saturate, stall, clock_step, garbage}) > 0.0;
  }
};

template <Source S>
class FaultInjector {
 public:
  FaultInjector(S source, const FaultParams& params) noexcept
      : source_(std::move(source)), params_(params), random_(static_cast<std::uint64_t>(params.seed) * 2 + 1) {}

  SourceState next(Arrival& out) noexcept {
    if (repeat_) {
      repeat_ = false;
      out = last_;
      return SourceState::kSample;
    }
    SourceState state = source_.next(out);
    while (state == SourceState::kSample && lost(out.sample.t_ns)) state = source_.next(out);
    if (state == SourceState::kSample) {
      damage(out.sample);
      repeat_ = happens(params_.duplicate);
      last_ = out;
    }
    return state;
  }
  void prepare() noexcept { pipeline::prepare(source_); }
  [[nodiscard]] bool live() const noexcept { return is_live(source_); }

 private:
  /// SplitMix64, uniform in [0, 1).
  double uniform() noexcept {
    std::uint64_t z = (random_ += 0x9E3779B97F4A7C15ULL);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
    return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1.0p-53;
  }
  bool happens(double probability) noexcept { return probability > 0.0 && uniform() < probability; }

  bool lost(std::int64_t t_ns) noexcept {
    if (happens(params_.stall)) stall_until_ns_ = t_ns + static_cast<std::int64_t>(1e9 * params_.stall_s);
    return t_ns < stall_until_ns_ || happens(params_.drop);
  }

  void damage(RawSample& sample) noexcept {
    if (happens(params_.clock_step)) clock_ns_ += static_cast<std::int64_t>(1e9 * params_.clock_step_s);
    if (std::abs(clock_ns_) > kFurthestClock_ns) clock_ns_ = 0;
    sample.t_ns += clock_ns_;
    Array3* const triads[] = {&sample.acc_mps2, &sample.gyr_radps, &sample.mag_uT};
    double& axis = (*triads[pick()])[pick()];
    if (happens(params_.not_finite)) {
      axis = happens(0.5) ? std::numeric_limits<double>::quiet_NaN() : std::numeric_limits<double>::infinity();
    }
    if (happens(params_.saturate)) axis = std::copysign(params_.saturate_limit, axis);
    if (happens(params_.garbage)) {
      for (double& x : *triads[pick()])
        x = std::ldexp(2.0 * uniform() - 1.0, static_cast<int>(2000.0 * uniform()) - 1000);
    }
  }
  std::size_t pick() noexcept { return static_cast<std::size_t>(3.0 * uniform()); }

  static constexpr std::int64_t kFurthestClock_ns = 2'000'000'000'000'000'000;  // 63 years off, and it is set right

  S source_;
  FaultParams params_;
  std::uint64_t random_;
  std::int64_t clock_ns_ = 0, stall_until_ns_ = std::numeric_limits<std::int64_t>::min();
  Arrival last_;
  bool repeat_ = false;
};

}  // namespace stillpoint::pipeline
