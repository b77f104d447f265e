/// The health of each sensor, from what the sensors say of each other: repetition, limits, units, and whether gravity
/// turns in the body as the gyroscope says. docs/decisions/081-one-judge-of-health.md.
#pragma once
#include <optional>
#include <type_traits>

#include "core/health.h"
#include "core/plausibility.h"
#include "fusion/attitude_estimate.h"
#include "pipeline/guard_stage.h"
#include "pipeline/noise_watch.h"

namespace stillpoint::pipeline {

/// Fed once a sample on the sensor thread; plain state, no allocation.
class HealthMonitor {
 public:
  /// What stands of what was found so far.
  void hear(std::span<const Finding> findings) noexcept;
  /// The sample as the stages use it, and what the filter made of it.
  SensorsHealth observe(const GuardedSample& guarded, const CalibratedSample& corrected,
                        const fusion::AttitudeEstimate& estimate) noexcept;
  /// A row that makes no sample, and who is overdue at its time (bits of SamplePart). Where no row has made one for a
  /// while, nobody else says that those who lead are silent.
  void wait(const RawSample& row, std::uint8_t absent) noexcept;

  [[nodiscard]] const SensorsHealth& now() const noexcept { return health_; }

  /// The attitude stands on sensors that contradict each other: nothing is known of its error.
  [[nodiscard]] static bool unfounded(const SensorsHealth& health) noexcept;

 private:
  static constexpr double kStuck_s = 1.0;  ///< noise changes a living reading long before
  static constexpr double kMean_s = 10.0, kNow_s = 1.0;
  /// Of a sound part that the data sheet calls noisy: 10 mg, 0.2 deg/s.
  static constexpr double kLeastNoise_mps2 = 0.05, kLeastNoise_radps = 0.003;

  struct Axis {
    double same_s = 0.0;
    double alive = 0.0;  ///< share of the last seconds before this run in which it changed
    Array3 others{};     ///< the reading when the run began
    double others_moved = 0.0;
  };
  /// Mean over so long at most, in which older values fade.
  struct FadingMean {
    double value = 0.0, over_s = 0.0;
    void add(double x, double dt_s, double longest_s) noexcept;
  };
  struct Readings {  ///< of one triad
    Array3 last{};
    std::array<Axis, 3> axes;
    double same_s = 0.0, zero_s = 0.0;
    double longest_same_s = 0.0;  ///< of the runs that ended
    FadingMean norm, norm_now;    ///< over ten seconds, over one
    double clipped = 0.0;         ///< share over the last second
    double spikes = 0.0;          ///< number in the last ten seconds
    bool heard = false;
    void note(const Array3& reading, bool clipped_now, double dt_s) noexcept;
    [[nodiscard]] double stuck_axis_s(double moved) const noexcept;
    [[nodiscard]] bool hung() const noexcept;
  };
  /// Gravity before and after a second, and the turn between them by the gyroscope.
  struct Turns {
    Array3 before{}, mean{};
    double mean_s = 0.0, since_s = 0.0;
    Array4 q{1, 0, 0, 0};              ///< body now to body at the start
    double unseen_s = 0.0;             ///< since a window that told something
    double with = 0.0, without = 0.0;  ///< squared change of gravity, with and without that turn
    double pull = 0.0, weight = 0.0;   ///< length of the mean force that the gyroscope carries along, in g
    int windows = 0;
    bool begun = false;
  };
  /// The mean force of the last second and of the last seconds, in the body now: the gyroscope carries both along.
  struct Pull {
    Array3 fast{}, slow{};
    double over_s = 0.0;
    double strong_s = 0.0, apart_s = 0.0;
    double contradicted_s = 0.0;  ///< so long is a contradiction remembered yet
  };
  void follow_gravity(const CalibratedSample& sample, double dt_s) noexcept;
  void follow_pull(const CalibratedSample& sample, const Array3& rate_radps, double dt_s) noexcept;
  [[nodiscard]] bool bus_hangs() const noexcept { return acc_.hung() && gyr_.hung(); }
  [[nodiscard]] SensorHealth judge_acc(const GuardedSample& g, bool offset_jumped) const noexcept;
  [[nodiscard]] SensorHealth judge_gyr(const GuardedSample& g, bool offset_jumped) const noexcept;
  [[nodiscard]] SensorHealth judge_mag(const GuardedSample& g, HeadingReference heading) const noexcept;
  [[nodiscard]] SensorHealth judge_temp(const GuardedSample& g) const noexcept;

  Readings acc_, gyr_, mag_;
  NoiseWatch acc_noise_{kLeastNoise_mps2}, gyr_noise_{kLeastNoise_radps};
  Turns turns_;
  Pull pull_;
  SensorsHealth found_;  ///< by the plausibility of the readings
  SensorsHealth health_ = unheard();
  std::optional<std::int64_t> waiting_since_ns_;  ///< time of the first row since the last sample
  double rest_s_ = 0.0, rest_norm_ = 0.0;         ///< of the specific force over the last second of rest
  double mag_same_turn_rad_ = 0.0;  ///< how far the body has turned while the magnetometer repeated itself
  double temp_silent_s_ = 0.0;
  std::int64_t last_ns_ = 0;
  bool started_ = false, temp_heard_ = false;
};

static_assert(std::is_trivially_copyable_v<HealthMonitor>);

}  // namespace stillpoint::pipeline
