#include "apps/stillpointd/health_watch.h"

#include <fmt/format.h>

namespace stillpoint::app {

std::vector<std::string> HealthWatch::news(const SensorsHealth& now) {
  struct Part {
    std::string_view sensor;
    const SensorHealth& health;
    bool needed;  // the attitude stands on it
  };
  const std::array<Part, 4> parts{{{"accelerometer", now.acc, true},
                                   {"gyroscope", now.gyr, true},
                                   {"magnetometer", now.mag, false},
                                   {"thermometer", now.temp, false}}};
  std::vector<std::string> lines;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const auto& [sensor, health, needed] = parts[i];
    Told& told = told_[i];
    const bool there = health.state != Health::kAbsent;
    const bool never_there = !there && !needed && !told.was_there;
    told.was_there = told.was_there || there;
    if (never_there || (health.state == told.state && health.fault == told.fault)) continue;
    told.state = health.state;
    told.fault = health.fault;
    if (health.state == Health::kOk) {
      lines.push_back(fmt::format("{}: ok again", sensor));
      continue;
    }
    const std::string how =
        there ? fmt::format("{} ({})", name(health.state), name(health.fault)) : "absent, no readings";
    lines.push_back(fmt::format("{}: {} since t = {:.2f} s", sensor, how, 1e-9 * static_cast<double>(health.since_ns)));
  }
  return lines;
}

}  // namespace stillpoint::app
