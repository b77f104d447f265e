/// Readings that cannot be what they are said to be: wrong units, repeats, clocks that do not run. One check for every
/// program; it takes readings one by one, allocates nothing, and tells kinds and numbers, no text.
/// docs/decisions/090-plausibility.md has the bounds and where they come from.
#pragma once
#include <array>
#include <cstdint>
#include <span>

#include "core/gravity_turns.h"
#include "core/log_histogram.h"
#include "core/types.h"

namespace stillpoint {

enum class Oddity : std::uint8_t {
  kAccScale,      ///< `value`: median of the readings, m/s^2
  kGyrScale,      ///< `value`: times what the turning of gravity says; 0 where gravity stands still
  kGyrSilent,     ///< `value`: by how much gravity turned that the gyroscope does not tell, rad
  kMagScale,      ///< `value`: median, uT
  kTimeScale,     ///< `value`: median step, s
  kTempScale,     ///< `value`: the reading, degC
  kRepeated,      ///< `value`: share of the readings that repeat the one before
  kTimeStopped,   ///< `value`: readings in a row with one time
  kTimeBackward,  ///< `value`: how far back, s
  kTimeJumped,    ///< `value`: how far on, s
  kTempDead,      ///< `value`: at which it stands, degC
  kTooSlow,       ///< `value`: median step of the gyroscope, s
};
inline constexpr std::size_t kOddities = 12;

/// What most likely was mistaken for what.
enum class Mistake : std::uint8_t {
  kNone,
  kGAsMps2,
  kMilliGAsMps2,
  kMps2AsG,
  kRange,  ///< a factor of 2, 4 or 8: the range that the sensor is set to
  kCounts,
  kDegpsAsRadps,
  kRadpsAsDegps,
  kGaussAsUT,
  kMilliTeslaAsUT,
  kTeslaAsUT,
  kUTAsGauss,
  kNanoTeslaAsUT,
  kMilliGaussAsUT,
  kMsAsS,
  kUsAsS,
  kSAsMs,
  kKelvinAsDegC,
  kMilliDegCAsDegC,
};

struct Finding {
  Oddity oddity{};
  Mistake mistake = Mistake::kNone;
  double value = 0.0;
  std::int64_t t_ns = 0;  ///< of the reading that gave it away
  bool stands = true;     ///< false: readings since then were right
};

/// 10 Hz and a little: further apart, how the body turned in between is not known and there is no attitude.
inline constexpr double kLongestGyrStep_s = 0.11;
[[nodiscard]] constexpr bool is_too_slow(const Finding& f) noexcept {
  return f.oddity == Oddity::kTooSlow || (f.oddity == Oddity::kTimeScale && f.value > kLongestGyrStep_s);
}

class PlausibilityCheck {
 public:
  void push(const RawSample& sample) noexcept;
  /// The device came back: all is judged anew, what was found stands until its readings are right.
  void restart() noexcept;

  /// In the order in which they were found; each oddity once.
  [[nodiscard]] std::span<const Finding> findings() const noexcept { return std::span(findings_).first(found_); }

 private:
  /// Of one sensor. A window is four seconds, and not fewer than fifty readings.
  struct Part {
    Array3 last{}, least{}, most{};  ///< `least` and `most`: of each axis of the magnetometer in this window
    std::int64_t last_ns = 0, window_start_ns = 0;
    LogHistogram norms, steps;
    std::uint32_t repeats = 0, same_time = 0, backward = 0;
    int odd_windows = 0, repeating_windows = 0;  ///< in a row; below 0: so many were right
    bool started = false, gravity_seen = false;
    /// Before the window counts the reading.
    void note_extent(const Array3& reading) noexcept;
  };

  void push_part(Part& part, const Array3& reading, std::int64_t t_ns, SamplePart kind) noexcept;
  void push_temp(double temp_degC, std::int64_t t_ns) noexcept;
  void judge_time(Part& part, std::int64_t t_ns) noexcept;
  void judge_window(Part& part, SamplePart kind, std::int64_t t_ns) noexcept;
  void judge_steps(const Part& part, std::int64_t t_ns) noexcept;
  void judge_gravity_turns(std::int64_t t_ns) noexcept;
  void find(Oddity oddity, Mistake mistake, double value, std::int64_t t_ns) noexcept;
  /// The readings are right by now.
  void clear(Oddity oddity) noexcept;
  [[nodiscard]] Finding* found(Oddity oddity) noexcept;

  std::array<Finding, kOddities> findings_{};
  std::size_t found_ = 0;
  Part acc_, gyr_, mag_;
  GravityTurns turns_;
  double first_temp_degC_ = 0.0;
  std::int64_t first_temp_ns_ = 0;
  std::uint32_t temps_ = 0;
  bool temp_moved_ = false;
  int odd_turns_ = 0;
};

}  // namespace stillpoint
