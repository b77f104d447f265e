/// What the parts of the pipeline promise each other. A stage, a source and a sink are plain classes; these concepts
/// are checked where the parts are put together, so a new source (IIO, serial, DDS) or sink touches no stage.
#pragma once
#include <concepts>
#include <cstdint>
#include <type_traits>

#include "core/types.h"

namespace stillpoint::pipeline {

enum class StageStatus : std::uint8_t {
  kOk,
  kDegraded,  ///< the output serves, but a part of it is missing or poor
  kDrop,      ///< no output: the sample goes no further
};

/// `process` runs on the sensor thread: wait-free, no allocation, no lock, no text. Its output is a function of its
/// inputs and their time stamps only, never of the wall clock.
template <class S>
concept Stage = requires(S stage, const typename S::Input& in, typename S::Output& out) {
  { stage.process(in, out) }
  noexcept->std::same_as<StageStatus>;
};

enum class SourceState : std::uint8_t {
  kSample,   ///< `sample` was filled
  kNothing,  ///< nothing arrived within the source's own waiting time; ask again
  kGone,     ///< the device or the peer vanished; it may come back
  kEnd,      ///< there will be no more
};

/// What a driver says of the white noise of one reading: standard deviations, 0 where it says nothing.
struct StatedNoise {
  double acc_mps2 = 0.0, gyr_radps = 0.0, mag_uT = 0.0;
  bool operator==(const StatedNoise&) const = default;
};

/// One reading on its way in. `arrival_ns` is CLOCK_MONOTONIC when the reading reached this machine; a source that
/// paces itself gives the instant at which the reading was due, so that a late wake-up counts as latency.
struct Arrival {
  RawSample sample;
  std::int64_t arrival_ns = 0;
  StatedNoise noise;  ///< of each sensor's latest reading, not of this one alone
};

/// `next` blocks in the kernel or sleeps until a reading is there, at most some 100 ms, so that a stop is noticed.
/// What a source can do for its next reading before that is due it may do in a function `prepare`.
template <class S>
concept Source = requires(S source, Arrival& out) {
  { source.next(out) }
  noexcept->std::same_as<SourceState>;
};

/// After a sample has been dealt with, while nothing waits.
template <Source S>
void prepare(S& source) noexcept {
  if constexpr (requires { source.prepare(); }) source.prepare();
}

/// Whether readings come at their own time and not at ours. Nothing may wait for a late answer of the calibration then;
/// a replay waits instead, so that its result does not depend on the machine. A source says so by `live()`.
template <Source S>
[[nodiscard]] bool is_live(const S& source) noexcept {
  if constexpr (requires { source.live(); }) return source.live();
  return false;
}

/// Takes each message on the sensor thread. False: the message was lost (counted by the caller).
template <class S, class Message>
concept Sink = requires(S sink, const Message& message) {
  { sink.publish(message) }
  noexcept->std::same_as<bool>;
};

}  // namespace stillpoint::pipeline
