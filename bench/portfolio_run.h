/// One series of samples with its truth through all stages, as `estimate` runs them: errors, and whether they were
/// stated.
#pragma once
#include <string>
#include <vector>

#include "core/calibration.h"
#include "core/types.h"
#include "core/units.h"
#include "pipeline/smooth.h"
#include "pipeline/stages.h"

namespace stillpoint::bench {

/// A true attitude at a time of its own.
struct Truth {
  std::int64_t t_ns = 0;
  Quat q_world_body = Quat::Identity();
  bool scored = true;  ///< counts in the errors; what was stated is judged everywhere
};

struct Series {
  std::string name;
  std::vector<RawSample> rows;
  std::vector<Truth> truths;  ///< in time order
  CalibrationSnapshot start;  ///< what the configuration knows of the sensor
};

/// One estimate against the truth, and against what it states of itself.
struct Judged {
  double total_rad = 0.0, heading_rad = 0.0, tilt_rad = 0.0;
  double tilt2 = 0.0,
         heading2 = 0.0;  ///< squared errors over their stated variances, of two and of one degree of freedom
  bool tilt_inside = false, heading_inside = false;  ///< three standard deviations
  bool ok = false;                                   ///< the published status
};
[[nodiscard]] Judged judge(const Quat& truth, const pipeline::Processed& estimate);

/// Sums over the truths of one series; degrees when read.
class Tally {
 public:
  void add(const Truth& truth, const pipeline::Processed& estimate);

  [[nodiscard]] double total_deg() const { return rms_deg(total2_, scored_); }
  [[nodiscard]] double heading_deg() const { return rms_deg(heading2_, scored_); }
  [[nodiscard]] double inclination_deg() const { return rms_deg(inclination2_, scored_); }
  [[nodiscard]] double tilt_inside() const { return share(tilt_inside_); }
  [[nodiscard]] double heading_inside() const { return share(heading_inside_); }
  /// Mean of the squared error over its stated variance, per degree of freedom: 1 where the covariance is true.
  [[nodiscard]] double tilt_nees() const { return share(tilt_nees_); }
  [[nodiscard]] double heading_nees() const { return share(heading_nees_); }
  /// Share of time outside three standard deviations while the status says ok.
  [[nodiscard]] double ok_outside() const { return share(ok_outside_); }
  [[nodiscard]] double worst_deg() const;
  [[nodiscard]] std::size_t judged() const { return judged_; }

 private:
  [[nodiscard]] static double rms_deg(double sum, std::size_t n);
  [[nodiscard]] double share(double sum) const { return judged_ > 0 ? sum / static_cast<double>(judged_) : 0.0; }

  double total2_ = 0.0, heading2_ = 0.0, inclination2_ = 0.0, worst_rad_ = 0.0;
  double tilt_inside_ = 0, heading_inside_ = 0, tilt_nees_ = 0.0, heading_nees_ = 0.0, ok_outside_ = 0;
  std::size_t scored_ = 0, judged_ = 0;
};

enum class Way : std::uint8_t { kCausal, kSmoothed };

/// `each(truth, estimate)` for every truth, with the estimate of the last sample at or before it, turned on by its
/// rate.
template <class Each>
void run_series(const Series& series, const pipeline::StagesParams& params, Way way, const Each& each) {
  calib::OnlineCalibrator calibrator({}, series.start);
  pipeline::Processed last;
  bool any = false;
  std::size_t next = 0;
  const auto judge = [&](std::int64_t until_ns) {
    for (; next < series.truths.size() && series.truths[next].t_ns < until_ns; ++next) {
      if (!any) continue;
      pipeline::Processed here = last;
      const double ahead_s = in_seconds(series.truths[next].t_ns - last.attitude.t_ns);
      const auto& e = last.attitude;
      const Quat q = quat(e.q_world_body) * exp_quat(ahead_s * vec(e.rate_body_radps));
      here.attitude.q_world_body = {q.w(), q.x(), q.y(), q.z()};
      each(series.truths[next], here);
    }
  };
  const auto take = [&](const pipeline::Processed& out) {
    judge(out.attitude.t_ns);
    last = out;
    any = true;
  };
  if (way == Way::kSmoothed) {
    const auto sample = [&series](std::size_t row) { return series.rows[row]; };
    for (const auto& out : pipeline::smooth(series.rows.size(), sample, params, calibrator).rows) take(out);
  } else {
    pipeline::DirectLink link(calibrator);
    pipeline::Stages stages(params, calibrator.snapshot());
    pipeline::Processed out;
    for (const RawSample& row : series.rows)
      if (stages.process(row, out, link) != pipeline::StageStatus::kDrop) take(out);
  }
  judge(INT64_MAX);
}

}  // namespace stillpoint::bench
