/// The first stage: lets nothing through that would poison a later one, and counts what it meets.
/// Inside the pipeline time only goes forward. A sensor whose clock was set is followed on its new time base.
/// The gyroscope leads: its readings carry the pipeline's time. A row without one waits for it (assemble_stage.h),
/// unless the gyroscope is silent; then the accelerometer leads. docs/decisions/150-merging-readings.md
#pragma once
#include <array>
#include <cstdint>

#include "core/fields.h"
#include "pipeline/sensor_clock.h"
#include "pipeline/spike_gate.h"
#include "pipeline/stage.h"

namespace stillpoint::pipeline {

/// Share of the full scale from which a reading is clipped: offsets that the sensor takes out shift its rail.
inline constexpr double kClippedFrom = 0.999;

struct GuardParams {
  double acc_limit_mps2 = 1e4;
  double gyr_limit_radps = 1e3;
  double mag_limit_uT = 1e5;
  double gap_factor = 2.5;
  double clock_step_s = 3600.0;
  double late_s = 0.01;

  template <class P = GuardParams>
  static constexpr auto fields() {
    return std::tuple{
        field("acc_limit_mps2", &P::acc_limit_mps2, positive(),
              "full scale; an axis at or beyond 99.9 % of it is clipped"),
        field("gyr_limit_radps", &P::gyr_limit_radps, positive(), "full scale of the gyroscope"),
        field("mag_limit_uT", &P::mag_limit_uT, positive(), "full scale of the magnetometer"),
        field("gap_factor", &P::gap_factor, in_range(1.1, 100.0),
              "a step longer than this times the usual one is a gap"),
        field("clock_step_s", &P::clock_step_s, in_range(1.0, 1e8),
              "a forward step longer than this is taken for a clock that was set, not for a pause"),
        field("late_s", &P::late_s, in_range(0.0, 0.5),
              "a reading in a row of its own joins the first gyroscope reading stamped at least so much later; "
              "one that arrives after that is refused")};
  }
};

/// Written by the sensor thread only.
struct GuardCounts {
  std::uint64_t samples = 0;      ///< rows that lead, used or refused
  std::uint64_t gaps = 0;         ///< steps too long, and jumps of the sequence
  std::uint64_t lost = 0;         ///< samples missing in the sequence
  std::uint64_t rows = 0;         ///< with anything measured
  std::uint64_t refused = 0;      ///< rows whose time repeats, runs backward or lies far ahead; without a usable part
  std::uint64_t out_of_time = 0;  ///< of these, for their time
  std::uint64_t late = 0;         ///< readings in rows of their own that came too late to be used
  std::uint64_t not_finite = 0;   ///< parts taken out
  std::uint64_t spikes = 0;       ///< the same, because no motion gives such a reading
  std::uint64_t clipped = 0;      ///< samples with a part at its limit
  std::uint64_t clock_steps = 0;  ///< the sensor's clock was set
  std::int64_t longest_gap_ns = 0;
  std::array<std::uint64_t, kSampleParts> readings{};  ///< usable ones of each part

  [[nodiscard]] std::uint64_t unused() const noexcept { return refused + late; }
};

/// A reading that may be used. Its time is the pipeline's own: the sensor's, shifted where the sensor's clock was set.
struct GuardedSample {
  RawSample sample;
  Array3 acc_turn_rad{};     ///< from the body at the accelerometer's reading to the body now; zero at the same time
  Array3 mag_turn_rad{};     ///< the same for the magnetometer
  std::uint8_t clipped = 0;  ///< bits of SamplePart
  std::uint8_t spikes = 0;   ///< bits of SamplePart: taken out, because no motion gives such a reading
  std::uint8_t absent = 0;   ///< bits of SamplePart: overdue by their own period, or never there
  bool leads = true;         ///< false: the row waits for the next one that leads
  bool after_gap = false;
};

class GuardStage {
 public:
  using Input = RawSample;
  using Output = GuardedSample;

  explicit GuardStage(const GuardParams& params = {}) noexcept : params_(params) {}
  /// kDrop: nothing of the row can be used, or it holds a temperature alone, which is kept for the next sample.
  StageStatus process(const RawSample& in, GuardedSample& out) noexcept;

  [[nodiscard]] const GuardCounts& counts() const noexcept { return counts_; }
  [[nodiscard]] bool temp_known() const noexcept { return temp_known_; }
  /// Usual step between samples, s; 0 before it is known.
  [[nodiscard]] double usual_step_s() const noexcept { return 1e-9 * clock_.usual_step_ns(); }
  /// Usual step between readings of each part, s.
  [[nodiscard]] std::array<double, kSampleParts> usual_steps_s() const noexcept;
  /// Bits of SamplePart: overdue by their own period, or never there.
  [[nodiscard]] std::uint8_t absent_at(std::int64_t t_ns) const noexcept;

 private:
  [[nodiscard]] bool leads(const RawSample& in) noexcept;
  [[nodiscard]] bool take_time(const RawSample& in, GuardedSample& out) noexcept;
  void refuse_time() noexcept {
    ++counts_.refused;
    ++counts_.out_of_time;
  }
  void take_out_unusable(GuardedSample& out) noexcept;
  void take_temperature(RawSample& sample) noexcept;
  void note_readings(const RawSample& sample) noexcept;
  [[nodiscard]] bool holds_triad(const RawSample& sample) const noexcept {
    return (sample.has & (kAcc | kGyr | kMag)) != 0;
  }

  GuardParams params_;
  GuardCounts counts_;
  SensorClock clock_;  ///< of the rows that lead
  std::array<ReadingTimes, kSampleParts> times_;
  SpikeGate acc_spikes_{320.0}, gyr_spikes_{30.0},
      mag_spikes_{500.0};  ///< beyond the swing of 16 g, 860 deg/s, a magnet at hand
  std::uint64_t last_sequence_ = 0;
  int rows_without_gyr_ = 0;          ///< with an accelerometer reading, in a row
  std::int64_t silent_since_ns_ = 0;  ///< of the first of these
  double temp_degC_ = 25.0;           ///< the last one measured
  bool started_ = false, gyr_seen_ = false, temp_known_ = false, temp_fresh_ = false;
};

static_assert(Stage<GuardStage>);

}  // namespace stillpoint::pipeline
