#include "apps/stillpointd/health_watch.h"

#include <fmt/format.h>

#include "core/units.h"

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
  silent_.clear();
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const auto& [sensor, health, needed] = parts[i];
    Told& told = told_[i];
    const bool there = health.state != Health::kAbsent;
    const bool never_there = !there && !needed && !told.was_there;
    told.was_there = told.was_there || there;
    if (never_there) continue;
    const std::string how =
        there ? fmt::format("{} ({})", name(health.state), name(health.fault)) : "absent, no readings";
    const std::string line = fmt::format("{}: {} since t = {:.2f} s", sensor, how, in_seconds(health.since_ns));
    if (!there) silent_ += (silent_.empty() ? "" : "; ") + line;
    if (health.state == told.state && health.fault == told.fault) continue;
    told.state = health.state;
    told.fault = health.fault;
    if (health.state == Health::kOk) {
      lines.push_back(fmt::format("{}: ok again", sensor));
      continue;
    }
    lines.push_back(line);
  }
  return lines;
}

}  // namespace stillpoint::app
