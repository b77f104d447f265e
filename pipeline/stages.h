/// The stages in their order, one call a row: guard -> assemble -> rest -> correct -> compensate -> attitude. The
/// daemon's sensor thread and the offline `estimate` run this same class; only the link to the calibration differs.
#pragma once
#include <optional>
#include <span>

#include "calib_online/field_turns.h"
#include "calib_online/rest_detector.h"
#include "core/attitude_message.h"
#include "core/plausibility.h"
#include "fusion/attitude_filter.h"
#include "pipeline/answer_schedule.h"
#include "pipeline/assemble_stage.h"
#include "pipeline/calibration_link.h"
#include "pipeline/compensate_stage.h"
#include "pipeline/correct_stage.h"
#include "pipeline/frame.h"
#include "pipeline/full_scale.h"
#include "pipeline/guard_stage.h"
#include "pipeline/health_monitor.h"

namespace stillpoint::pipeline {

/// The smallest that accelerometers (2 g) and gyroscopes (125 deg/s) are sold with, less the offset of a rail.
inline constexpr double kSmallestAccScale_mps2 = 17.0;
inline constexpr double kSmallestGyrScale_radps = 2.0;

struct StagesParams {
  GuardParams guard;
  calib::RestDetectorParams rest;
  fusion::AttitudeFilterParams attitude;
  Compensation compensation;
  OutputFrame frame;
  std::optional<double> initial_heading_rad;
  double answer_delay_s = 0.1;  ///< from the end of a piece of evidence to the use of what was learnt from it
  bool learn = true;            ///< false: the calibration of the start serves all the time
};

/// One sample, all the way through.
struct Processed {
  fusion::AttitudeEstimate attitude;  ///< in the output frame
  CalibratedSample sample;            ///< corrected and compensated, in the sensor's frame
  bool after_gap = false;
  SensorsHealth health;
  bool temp_measured = false;  ///< the temperature is the sensor's own, now or a little while ago
};

/// Without the readings of faulty sensors: one of those does not speak, and the filter knows how to live without.
[[nodiscard]] CalibratedSample believed(const CalibratedSample& sample, const SensorsHealth& health) noexcept;

/// As it is published; what only the publishing thread knows (arrival, counters) is left at its default.
[[nodiscard]] AttitudeMessage to_message(const Processed& processed) noexcept;

/// Counted on the sensor thread.
struct StagesCounts {
  std::uint64_t windows = 0;           ///< rest windows handed to the calibration
  std::uint64_t evidence_dropped = 0;  ///< the ring was full
  std::uint64_t answers_late = 0;      ///< answers that were not there when they should have taken effect
  std::uint64_t gate_refused = 0;      ///< estimates that were not a finite unit quaternion: never let out
};

class Stages {
 public:
  Stages(const StagesParams& params, const CalibrationSnapshot& start) noexcept
      : params_(params),
        guard_(params.guard),
        assemble_(params.guard.late_s, start.gyr),
        rest_(rest_of(params)),
        correct_(start),
        compensate_(params.compensation),
        filter_(params.attitude) {
    filter_.know(start);
    filter_.reset(params.initial_heading_rad);
  }

  /// kDrop: nothing may be published for this row.
  template <CalibrationLink Link>
  StageStatus process(const RawSample& raw, Processed& out, Link& link) noexcept {
    GuardedSample row, guarded;
    const StageStatus guarded_as = guard_.process(raw, row);
    RawSample as_it_came = raw;  // its times as well, but no broken transfers: what is left shows the unit
    as_it_came.has = static_cast<std::uint8_t>(raw.has & ~row.spikes);
    plausibility_.push(as_it_came);
    if (!row.leads && SensorClock::is_time(row.sample.t_ns))
      health_.wait(row.sample, guard_.absent_at(row.sample.t_ns));
    if (guarded_as == StageStatus::kDrop) return StageStatus::kDrop;
    find_rails(row);
    if (assemble_.process(row, guarded) == StageStatus::kDrop) return StageStatus::kDrop;
    take_answer(guarded.sample.t_ns, link);
    find_window(guarded.sample, link);
    find_turn(guarded, link);
    CalibratedSample corrected;
    correct_.process(guarded, corrected);
    compensate_.process(corrected, out.sample);
    out.after_gap = guarded.after_gap;
    out.temp_measured = guard_.temp_known();
    return estimate(guarded, out);
  }

  /// The noise of the readings from here on, where the driver states one.
  void hear(const StatedNoise& noise) noexcept { stated_ = noise; }
  /// The device was gone: another one may be there now.
  void source_returned() noexcept { plausibility_.restart(); }

  [[nodiscard]] std::span<const Finding> findings() const noexcept { return plausibility_.findings(); }
  [[nodiscard]] const GuardStage& guard() const noexcept { return guard_; }
  [[nodiscard]] const SensorsHealth& health() const noexcept { return health_.now(); }
  [[nodiscard]] const StagesCounts& counts() const noexcept { return counts_; }
  [[nodiscard]] const CalibrationSnapshot& live() const noexcept { return correct_.live(); }
  [[nodiscard]] const fusion::AttitudeFilter& filter() const noexcept { return filter_; }
  [[nodiscard]] calib::Refusal last_refusal() const noexcept { return rest_.last_refusal(); }

 private:
  /// One full scale serves both: what the guard calls clipped is no evidence of rest.
  static calib::RestDetectorParams rest_of(const StagesParams& params) noexcept {
    calib::RestDetectorParams rest = params.rest;
    rest.acc_limit_mps2 = kClippedFrom * params.guard.acc_limit_mps2;
    rest.gyr_limit_radps = kClippedFrom * params.guard.gyr_limit_radps;
    rest.mag_limit_uT = kClippedFrom * params.guard.mag_limit_uT;
    return rest;
  }

  void find_rails(GuardedSample& guarded) noexcept {
    if (guarded.sample.holds(kAcc) && acc_scale_.at_rail(guarded.sample.acc_mps2)) guarded.clipped |= kAcc;
    if (guarded.sample.holds(kGyr) && gyr_scale_.at_rail(guarded.sample.gyr_radps)) guarded.clipped |= kGyr;
  }

  template <CalibrationLink Link>
  void take_answer(std::int64_t t_ns, Link& link) noexcept {
    const auto due = schedule_.due(t_ns);
    if (!due) return;
    const auto answer = link.answer(*due);
    if (!answer) {
      if (!late_) ++counts_.answers_late;
      late_ = true;
      return;
    }
    late_ = false;
    schedule_.taken(*due);
    if (answer->snapshot.version == live().version) return;
    const CalibrationSnapshot before = correct_.in_force();
    correct_.use(answer->snapshot);
    filter_.rebase(before, correct_.in_force());
    assemble_.use(answer->snapshot.gyr);
  }

  template <CalibrationLink Link>
  void find_window(const RawSample& sample, Link& link) noexcept {
    auto window = rest_.push(sample, live());
    if (!window) return;
    if (window->has != 0) {  // else it tells of a fault alone
      compensate_.compensate(*window, live());
      ++counts_.windows;
    }
    if (!params_.learn) return;
    submit(*window, link);
  }

  template <CalibrationLink Link>
  void find_turn(const GuardedSample& guarded, Link& link) noexcept {
    auto turn = turns_.push(guarded.sample, guarded.clipped, live(), guarded.mag_turn_rad);
    if (!turn || !params_.learn) return;
    compensate_.compensate(*turn, live());
    submit(*turn, link);
  }

  template <class Found, CalibrationLink Link>
  void submit(const Found& found, Link& link) noexcept {
    const std::int64_t due_ns = found.t_end_ns + static_cast<std::int64_t>(1e9 * params_.answer_delay_s);
    if (schedule_.full() || !link.submit({schedule_.next(), found})) {
      ++counts_.evidence_dropped;
      return;
    }
    schedule_.submitted(due_ns);
  }

  [[nodiscard]] fusion::WhiteNoise noise() const noexcept;
  StageStatus estimate(const GuardedSample& guarded, Processed& out) noexcept;

  StagesParams params_;
  StatedNoise stated_;
  PlausibilityCheck plausibility_;
  GuardStage guard_;
  AssembleStage assemble_;
  AnswerSchedule schedule_;
  FullScale acc_scale_{kSmallestAccScale_mps2}, gyr_scale_{kSmallestGyrScale_radps};
  calib::RestDetector rest_;
  calib::FieldTurnFinder turns_;
  CorrectStage correct_;
  CompensateStage compensate_;
  fusion::AttitudeFilter filter_;
  HealthMonitor health_;
  StagesCounts counts_;
  bool late_ = false;
  bool other_unit_ = false;  ///< the gyroscope spoke in one
};

}  // namespace stillpoint::pipeline
