#include "apps/stillpoint/watch_model.h"
#include "core/units.h"

#include <algorithm>

namespace stillpoint::app {
namespace {
constexpr std::int64_t kSecond_ns = 1'000'000'000;
}

void WatchModel::take(const AttitudeMessage& message, std::int64_t t_receive_ns) {
  const std::lock_guard lock(mutex_);
  if (state_.attitude) {
    const std::uint64_t before = state_.attitude->sequence;
    if (message.sequence > before + 1) state_.lost += message.sequence - before - 1;
    if (message.sequence < before) ++state_.restarts;
  }
  state_.attitude = message;
  ++state_.received;
  const std::int64_t since_ns = message.t_arrival_ns != 0 ? message.t_arrival_ns : message.t_publish_ns;
  const std::int64_t latency_ns = t_receive_ns - since_ns;
  ++state_.latency_counts[latency_bucket(latency_ns)];
  state_.latency_max_ns = std::max(state_.latency_max_ns, latency_ns);
  last_second_ns_.push_back(t_receive_ns);
  while (t_receive_ns - last_second_ns_.front() > kSecond_ns) last_second_ns_.pop_front();
}

void WatchModel::take(const CalibrationMessage& message) {
  const std::lock_guard lock(mutex_);
  state_.calibration = message;
}

void WatchModel::take(const DiagnosticsMessage& message) {
  const std::lock_guard lock(mutex_);
  state_.diagnostics = message;
}

io::DdsHandlers WatchModel::handlers() {
  return {.attitude = [this](const AttitudeMessage& m, std::int64_t t_ns) { take(m, t_ns); },
          .calibration = [this](const CalibrationMessage& m) { take(m); },
          .diagnostics = [this](const DiagnosticsMessage& m) { take(m); }};
}

WatchState WatchModel::state(std::int64_t now_ns) const {
  const std::lock_guard lock(mutex_);
  WatchState copy = state_;
  if (last_second_ns_.empty()) return copy;
  copy.age_s = in_seconds(now_ns - last_second_ns_.back());
  const auto span_ns = last_second_ns_.back() - last_second_ns_.front();
  if (span_ns > 0 && copy.age_s < 1.0)
    copy.rate_hz = 1e9 * static_cast<double>(last_second_ns_.size() - 1) / static_cast<double>(span_ns);
  return copy;
}

}  // namespace stillpoint::app
