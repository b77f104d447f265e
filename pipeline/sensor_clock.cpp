#include "pipeline/sensor_clock.h"

namespace stillpoint::pipeline {
namespace {

/// So many readings in a row that advance among themselves, all behind the last one let through: the clock was set
/// back.
constexpr int kBackwardRun = 8;

}  // namespace

bool SensorClock::advance(std::int64_t sensor_ns, double gap_factor, double clock_step_s, Step& out) noexcept {
  if (!is_time(sensor_ns) || last_ns_ > kLargest_ns) return false;
  out = Step{.t_ns = sensor_ns};
  if (!started_) return true;
  std::int64_t step = sensor_ns - last_sensor_ns_;
  const auto one_step = std::max<std::int64_t>(1, static_cast<std::int64_t>(usual_.ns()));
  if (step <= 0) {
    const bool follows = backward_run_ > 0 && sensor_ns > backward_last_ns_;
    backward_run_ = follows ? backward_run_ + 1 : 1;
    backward_last_ns_ = sensor_ns;
    if (backward_run_ < kBackwardRun) return false;
    // What was refused meanwhile took time; the gap that remains is what the filter must bridge.
    step = kBackwardRun * one_step;
  } else if (static_cast<double>(step) > 1e9 * clock_step_s) {
    step = one_step;
  } else {
    backward_run_ = 0;
    out.t_ns = last_ns_ + step;
    out.gap = usual_.ns() > 0.0 && static_cast<double>(step) > gap_factor * usual_.ns();
    if (out.gap) out.gap_ns = step;
    usual_.learn(step);
    return true;
  }
  backward_run_ = 0;
  out.clock_was_set = out.gap = true;
  last_sensor_ns_ = sensor_ns - step;  // on its new time base
  out.t_ns = last_ns_ + step;
  return true;
}

}  // namespace stillpoint::pipeline
