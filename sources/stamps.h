/// Times of a stream's readings: the sender's own where it gives them, else those of arrival without their jitter.
#pragma once
#include <array>
#include <cstdint>
#include <optional>

#include "pipeline/sensor_clock.h"
#include "sources/reading.h"

namespace stillpoint::sources {

/// Even times out of uneven arrivals: a loop that follows phase and rate with a time constant of a second, so that
/// neither the 16 ms of a USB serial chip nor a burst after a pause moves them. A reading is stamped where it was due.
class ArrivalClock {
 public:
  /// `rate_hz` 0: learnt from the readings of the first second, which get no stamp.
  explicit ArrivalClock(double rate_hz = 0.0) noexcept : period_ns_(rate_hz > 0.0 ? 1e9 / rate_hz : 0.0) {}

  /// False: the rate is not known yet. `steps`: by how much the sender's count went on.
  bool stamp(std::int64_t arrival_ns, std::uint64_t steps, std::int64_t& t_ns) noexcept;
  /// The stream was cut: the phase is taken anew.
  void restart() noexcept { locked_ = false; }
  [[nodiscard]] double period_ns() const noexcept { return period_ns_; }

 private:
  bool learn(std::int64_t arrival_ns, std::uint64_t steps) noexcept;

  double period_ns_;
  double next_ns_ = 0.0;  ///< when the reading after the last one is due, counted from `epoch_ns_`
  std::int64_t epoch_ns_ = 0, last_ns_ = 0;
  std::uint64_t learnt_ = 0;
  bool locked_ = false, started_ = false;
};

/// One for a stream.
class Stamps {
 public:
  explicit Stamps(double rate_hz) noexcept { clocks_.fill(ArrivalClock(rate_hz)); }

  /// Puts the time into the sample. False: none can be given to this one.
  bool stamp(Reading& reading, std::int64_t arrival_ns, std::uint64_t steps) noexcept;
  /// The stream was cut. A sender that began to count anew is followed as if it had gone on.
  void restart() noexcept;

  /// How often a sender began anew on a stream that was not cut, and for how long nothing had come the last time.
  [[nodiscard]] std::uint64_t began_anew() const noexcept { return began_anew_; }
  [[nodiscard]] std::int64_t away_ns() const noexcept { return away_ns_; }

 private:
  struct Suspect {
    std::int64_t sender_ns = 0, away_ns = 0;
  };

  [[nodiscard]] std::int64_t unwrapped(const Reading& reading) noexcept;
  [[nodiscard]] bool suspects(std::int64_t sender_ns, std::int64_t& t_ns, std::int64_t arrival_ns) noexcept;
  void follow(std::int64_t sender_ns, std::int64_t due_ns, std::int64_t& t_ns) noexcept;

  std::array<ArrivalClock, 16> clocks_;  ///< by the parts held: sensors that come one by one have rates of their own
  std::int64_t offset_ns_ = 0, last_ns_ = 0, last_arrival_ns_ = 0;
  std::optional<std::int64_t> wrapped_ns_;  ///< time of the first reading after the counter's end
  pipeline::UsualStep arrivals_;            ///< of readings that did not come at once
  std::optional<Suspect> suspect_;          ///< the last reading, which may be the first of a sender that began anew
  std::uint64_t began_anew_ = 0;
  std::int64_t away_ns_ = 0;
  bool device_time_ = false;  ///< since the start or the last cut
  bool ever_ = false, restarted_ = false;
};

}  // namespace stillpoint::sources
