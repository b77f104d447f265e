/// What `stillpoint watch` knows about a daemon from its messages, and the same for scripts.
#pragma once
#include <cstdint>
#include <deque>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "core/attitude_message.h"
#include "io/dds_subscriber.h"

namespace stillpoint::app {

/// A whole copy of the knowledge at one instant.
struct WatchState {
  std::optional<AttitudeMessage> attitude;
  std::optional<CalibrationMessage> calibration;
  std::optional<DiagnosticsMessage> diagnostics;
  std::uint64_t received = 0;
  std::uint64_t lost = 0;      ///< attitudes published but not received, by their sequence
  std::uint64_t restarts = 0;  ///< the sequence began anew
  double rate_hz = 0.0;        ///< over the last second
  double age_s = 0.0;          ///< since the last attitude
  /// Arrival at the daemon to this process; publish to this process where that is unknown.
  LatencyCounts latency_counts{};
  std::int64_t latency_max_ns = 0;
};

/// Filled by the DDS threads, read by the view.
class WatchModel {
 public:
  void take(const AttitudeMessage& message, std::int64_t t_receive_ns);
  void take(const CalibrationMessage& message);
  void take(const DiagnosticsMessage& message);
  /// Of a subscriber that fills this model, which lives longer.
  [[nodiscard]] io::DdsHandlers handlers();
  [[nodiscard]] WatchState state(std::int64_t now_ns) const;

 private:
  mutable std::mutex mutex_;
  WatchState state_;
  std::deque<std::int64_t> last_second_ns_;  ///< times of receipt
};

/// For scripts: SI and radians, null where there is no value.
[[nodiscard]] nlohmann::json json_view(const WatchState& state);

}  // namespace stillpoint::app
