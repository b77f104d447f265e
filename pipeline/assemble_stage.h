/// One sample per gyroscope reading from sensors that speak at their own times. Readings in rows of their own wait
/// until a gyroscope reading stamped `late_s` later; then their mean goes with it, and with it how the body has turned
/// since, so that each is used in the attitude of its own stamp. A function of stamps only, as long as no reading
/// arrives later than that: the same live and from a recording (docs/decisions/150-merging-readings.md).
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

#include "core/calibration.h"
#include "pipeline/guard_stage.h"

namespace stillpoint::pipeline {

class AssembleStage {
 public:
  using Input = GuardedSample;
  using Output = GuardedSample;

  AssembleStage(double late_s, const TriadCalibration& gyr) noexcept
      : late_ns_(static_cast<std::int64_t>(1e9 * late_s)), gyr_(gyr) {}

  /// kDrop: the row waits for the next one that leads.
  StageStatus process(const GuardedSample& in, GuardedSample& out) noexcept;

  /// The gyroscope's calibration in force: what turns the waiting readings.
  void use(const TriadCalibration& gyr) noexcept { gyr_ = gyr; }

 private:
  static constexpr std::size_t kMost = 64;  ///< waiting readings of a sensor; of more the oldest are left out

  struct Reading {
    std::int64_t t_ns = 0;
    Array3 value{};
    bool clipped = false;
  };
  struct Waiting {
    std::array<Reading, kMost> readings;
    std::size_t first = 0, count = 0;
    void push(const Reading& reading) noexcept;
    [[nodiscard]] const Reading& front() const noexcept { return readings[first]; }
    void pop() noexcept;
  };
  struct Turn {  ///< the rate of a step that ended at t_ns
    std::int64_t t_ns = 0;
    Array3 rate_radps{};  ///< as read
  };

  void note_turn(const RawSample& sample) noexcept;
  void join(Waiting& waiting, SamplePart part, Array3& value, Array3& turn_rad, GuardedSample& out) noexcept;
  /// Rotation vector from the body at `from_ns` to the body at the last sample.
  [[nodiscard]] Vec3 turned_since(std::int64_t from_ns, double temp_degC) const noexcept;

  std::int64_t late_ns_;
  TriadCalibration gyr_;
  Waiting acc_, mag_;
  std::array<Turn, kMost> turns_;
  std::size_t newest_ = 0, turns_known_ = 0;
};

static_assert(Stage<AssembleStage>);

}  // namespace stillpoint::pipeline
