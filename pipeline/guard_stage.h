/// The first stage: lets nothing through that would poison a later one, and counts what it meets.
/// Inside the pipeline time only goes forward. A sensor whose clock was set is followed on its new time base.
#pragma once
#include <cstdint>

#include "core/fields.h"
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

  static constexpr auto fields() {
    using P = GuardParams;
    return std::tuple{field("acc_limit_mps2", &P::acc_limit_mps2, positive(),
                            "full scale; an axis at or beyond 99.9 % of it is clipped"),
                      field("gyr_limit_radps", &P::gyr_limit_radps, positive(), "full scale of the gyroscope"),
                      field("mag_limit_uT", &P::mag_limit_uT, positive(), "full scale of the magnetometer"),
                      field("gap_factor", &P::gap_factor, in_range(1.1, 100.0),
                            "a step longer than this times the usual one is a gap"),
                      field("clock_step_s", &P::clock_step_s, in_range(1.0, 1e8),
                            "a forward step longer than this is taken for a clock that was set, not for a pause")};
  }
};

/// Written by the sensor thread only.
struct GuardCounts {
  std::uint64_t samples = 0;      ///< that came in
  std::uint64_t gaps = 0;         ///< steps too long, and jumps of the sequence
  std::uint64_t lost = 0;         ///< samples missing in the sequence
  std::uint64_t refused = 0;      ///< not finite, repeated, backward or empty
  std::uint64_t not_finite = 0;   ///< parts taken out
  std::uint64_t clipped = 0;      ///< samples with a part at its limit
  std::uint64_t clock_steps = 0;  ///< the sensor's clock was set
  std::int64_t longest_gap_ns = 0;
};

/// A reading that may be used. Its time is the pipeline's own: the sensor's, shifted where the sensor's clock was set.
struct GuardedSample {
  RawSample sample;
  std::uint8_t clipped = 0;  ///< bits of SamplePart
  bool after_gap = false;
};

class GuardStage {
 public:
  using Input = RawSample;
  using Output = GuardedSample;
  static constexpr std::string_view kName = "guard";

  explicit GuardStage(const GuardParams& params = {}) noexcept : params_(params) {}
  StageStatus process(const RawSample& in, GuardedSample& out) noexcept;

  [[nodiscard]] const GuardCounts& counts() const noexcept { return counts_; }
  [[nodiscard]] bool temp_known() const noexcept { return temp_known_; }
  /// Usual step between samples, s; 0 before it is known.
  [[nodiscard]] double usual_step_s() const noexcept { return 1e-9 * usual_step_ns_; }

 private:
  /// False: the time does not advance. Otherwise `t_ns` is set to the pipeline's time.
  bool advance(std::int64_t sensor_ns, std::int64_t& t_ns, bool& gap) noexcept;
  void learn_step(std::int64_t step_ns) noexcept;

  GuardParams params_;
  GuardCounts counts_;
  std::int64_t last_ns_ = 0;           ///< pipeline time of the last sample let through
  std::int64_t last_sensor_ns_ = 0;    ///< the sensor's own time of that sample
  std::int64_t backward_last_ns_ = 0;  ///< last of a run of sensor times that lie behind
  int backward_run_ = 0;
  double usual_step_ns_ = 0.0;
  std::uint64_t last_sequence_ = 0;
  double temp_degC_ = 25.0;  ///< the last one measured
  bool started_ = false, temp_known_ = false;
};

static_assert(Stage<GuardStage>);

}  // namespace stillpoint::pipeline
