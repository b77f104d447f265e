#include "apps/stillpoint/watch_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "apps/stillpoint/live_words.h"
#include "apps/stillpoint/screen.h"
#include "core/units.h"
#include "io/quote.h"

namespace stillpoint::app {
namespace {

constexpr std::size_t kTrend = 24;  // characters a curve

Colour of(AttitudeStatus status) {
  return status == AttitudeStatus::kOk      ? Colour::kGood
         : status == AttitudeStatus::kStale ? Colour::kBad
                                            : Colour::kWarn;
}
Colour of(HeadingReference heading) {
  return heading == HeadingReference::kMagnetic || heading == HeadingReference::kTrue ? Colour::kGood : Colour::kWarn;
}
Colour of(Health health) {
  return health == Health::kOk ? Colour::kGood : health == Health::kFaulty ? Colour::kBad : Colour::kWarn;
}
Colour of(CalibrationStatus status) { return status == CalibrationStatus::kOk ? Colour::kGood : Colour::kWarn; }

/// One angle of the last half minute, from its least to its largest value, and whether its sigma grows.
std::string trend(const std::deque<CurvePoint>& curve, std::size_t axis) {
  std::vector<double> angles, sigmas;
  for (const CurvePoint& p : curve) {
    if (!std::isfinite(p.rpy_rad[axis]) || !std::isfinite(p.sigma_rad[axis])) continue;
    const double turned = angles.empty() ? 0.0 : std::remainder(p.rpy_rad[axis] - angles.back(), 2 * std::numbers::pi);
    angles.push_back(angles.empty() ? p.rpy_rad[axis] : angles.back() + turned);  // 179 to -179 deg is a step of 2
    sigmas.push_back(p.sigma_rad[axis]);
  }
  if (angles.size() < 2) return {};
  const auto [least, most] = std::minmax_element(angles.begin(), angles.end());
  const double grown = sigmas.back() / sigmas.front();
  const char* word = grown > 1.1 ? "growing" : grown < 0.9 ? "shrinking" : "steady";
  return fmt::format("{:<9}  {}  {:6.1f}", word, sparkline(angles, kTrend), kDegPerRad * (*most - *least));
}

std::string angle_lines(const AttitudeMessage& m, const std::deque<CurvePoint>& curve) {
  const Vec3 rpy = kDegPerRad * roll_pitch_yaw(m.q_world_body_xyzw);
  const double span_s = curve.empty() ? 0.0 : curve.back().t_s - curve.front().t_s;
  std::string out = fmt::format("{:<5}  {:>8}  {:>8}", "", "deg", "sigma");
  if (span_s > 0)
    out += fmt::format("  {:<9}  {:<24}  {:>6}", "", fmt::format("last {:.0f} s, . low # high", span_s), "span");
  out += "\n";
  constexpr std::array kAngle{"roll", "pitch", "yaw"};
  for (std::size_t i = 0; i < kAngle.size(); ++i)
    out += fmt::format("{:<5}  {:8.2f}  {:8.2f}  {}\n", kAngle[i], rpy[static_cast<Eigen::Index>(i)],
                       kDegPerRad * m.sigma_rpy_rad[i], trend(curve, i));
  return out;
}

std::string sensor_lines(const AttitudeMessage& m, const CalibrationMessage& message) {
  std::string out = fmt::format("sensor  health                 calibration {}\n", message.snapshot.version);
  const auto sensors = triads(message.snapshot);
  const std::array health{&m.health.acc, &m.health.gyr, &m.health.mag};
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    const TriadCalibration& c = *sensors[i];
    out += fmt::format("{:<6}  {}  {}  {} windows, {:.0f} to {:.0f} degC\n", kSensorName[i],
                       coloured(of(health[i]->state), fmt::format("{:<21}", health_words(*health[i]))),
                       coloured(of(c.status), word(c.status)), c.windows, c.temp_min_degC, c.temp_max_degC);
    out += fmt::format("        bias {}\n", bias_words(c, i, 4));
    if (!message.reasons[i].empty()) out += fmt::format("        {}\n", io::printable(message.reasons[i]));
  }
  return out;
}

}  // namespace

std::string text_view(const WatchState& s, const std::deque<CurvePoint>& curve, bool in_colour) {
  if (!s.attitude) return {};
  const AttitudeMessage& m = *s.attitude;
  std::string out = fmt::format(
      "t {:.2f} s   {}   {}   heading {}   {}\n", in_seconds(m.t_ns), coloured(of(m.status), name(m.status)),
      m.at_rest ? "AT REST" : "moving ", coloured(of(m.heading_reference), name(m.heading_reference)),
      std::isfinite(m.temp_degC) ? fmt::format("{:.1f} degC", m.temp_degC) : "no temperature");
  out += angle_lines(m, curve);
  out += fmt::format("rate   {:8.2f} {:8.2f} {:8.2f} deg/s   gyro bias left {:.3f} {:.3f} {:.3f}\n",
                     kDegPerRad * m.rate_radps[0], kDegPerRad * m.rate_radps[1], kDegPerRad * m.rate_radps[2],
                     kDegPerRad * m.gyro_bias_radps[0], kDegPerRad * m.gyro_bias_radps[1],
                     kDegPerRad * m.gyro_bias_radps[2]);
  if (s.calibration) out += sensor_lines(m, *s.calibration);
  out += fmt::format("received {} at {:.1f} Hz   lost {}   source gaps {}   dropped {}\n", s.received, s.rate_hz,
                     s.lost, m.gaps, m.dropped);
  out += fmt::format("latency p50 {:.0f} us  p99 {:.0f} us  max {:.0f} us\n", percentile_us(s.latency_counts, 0.5),
                     percentile_us(s.latency_counts, 0.99), 1e-3 * static_cast<double>(s.latency_max_ns));
  if (s.diagnostics && !s.diagnostics->last_refusal.empty())
    out += fmt::format("rest refused: {}\n", io::printable(s.diagnostics->last_refusal));
  if (s.diagnostics && !s.diagnostics->missing.empty())
    out += coloured(Colour::kWarn, "trouble: " + io::printable(s.diagnostics->missing)) + "\n";
  if (s.age_s > 1.0) out += coloured(Colour::kBad, fmt::format("NO NEW ATTITUDE for {:.1f} s", s.age_s)) + "\n";
  return on_screen(out, in_colour);
}

}  // namespace stillpoint::app
