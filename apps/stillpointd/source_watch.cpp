#include "apps/stillpointd/source_watch.h"

#include <fmt/format.h>

#include <cmath>

#include "core/types.h"
#include "core/units.h"
#include "io/plausibility_text.h"
#include "io/quote.h"

namespace stillpoint::app {

using sources::LinkState;
using sources::SourceReport;

namespace {

std::string_view time_unit(double unit_ns) {
  return unit_ns == 1e9 ? "s" : unit_ns == 1e6 ? "ms" : unit_ns == 1e3 ? "us" : "ns";
}

/// The coarsest unit in which such a time can be.
std::string likely_unit(double time) {
  for (const double unit_ns : {1e9, 1e6, 1e3, 1.0})
    if (std::abs(time) * unit_ns < static_cast<double>(kLatest_ns))
      return fmt::format("likely in {0}: name the column time_{0}", time_unit(unit_ns));
  return "send a time since the start, or no time, and that of arrival serves";
}

/// After a message.
std::string hint(sources::LineLook look) {
  return look == sources::LineLook::kUnknown ? "" : fmt::format("; {}", sources::advice(look));
}

}  // namespace

void SourceWatch::tell_link(const SourceReport& now, std::vector<std::string>& lines) {
  const bool changed = now.link != told_.link;
  if (now.link == LinkState::kThere) {
    if (changed) lines.push_back(fmt::format("source: there{}", told_.link == LinkState::kGone ? " again" : ""));
    told_failure_.clear();
    failures_when_there_ = now.failures;
    return;
  }
  if (changed && now.link == LinkState::kGone) lines.emplace_back("source: gone; it is waited for");
  if (now.failures == failures_when_there_ || now.error.view() == told_failure_) return;
  told_failure_ = now.error.view();
  lines.push_back(fmt::format("source: {}; it is tried again", io::printable(told_failure_)));
}

void SourceWatch::tell_clock(const SourceReport& now, std::vector<std::string>& lines) {
  if (now.began_anew == told_.began_anew) return;
  lines.push_back(
      fmt::format("source: the sender's stamps began anew after {:.2f} s without a reading ({} so far); how long that "
                  "took is known by arrival alone",
                  in_seconds(now.away_ns), now.began_anew));
}

void SourceWatch::tell_times(const SourceReport& now, std::vector<std::string>& lines) {
  times_trouble_.clear();
  if (now.times_refused == told_.times_refused) return;
  times_trouble_ = fmt::format("rows are refused: the line's time 'time_{}' = {:.6g} lies beyond 146 years; {}",
                               time_unit(now.refused_time_unit_ns), now.refused_time, likely_unit(now.refused_time));
  if (now.times_refused < tell_times_at_) return;
  lines.push_back(fmt::format("source: {} {}", now.times_refused, times_trouble_));
  tell_times_at_ = 10 * now.times_refused;
}

void SourceWatch::tell_names(const SourceReport& now, std::vector<std::string>& lines) {
  if (const std::string_view names = now.unknown_names.view(); !names.empty() && names != told_.unknown_names.view())
    lines.push_back(
        fmt::format("source: passed over, as their names are not known: {}; ours are such as acc_x_g, gyr_x_dps, "
                    "mag_x_uT, and 'source: columns' says which is which",
                    io::printable(names)));
  if (const std::string_view faults = now.header_faults.view(); !faults.empty() && faults != told_.header_faults.view())
    lines.push_back(fmt::format("source: {}", io::printable(faults)));
}

void SourceWatch::tell_damage(const SourceReport& now, std::vector<std::string>& lines) {
  if (now.malformed >= tell_malformed_at_) {
    lines.push_back(fmt::format("source: {} damaged lines or frames so far, the last {}{}", now.malformed,
                                io::quote(now.refused.view()), hint(now.look)));
    tell_malformed_at_ = 10 * now.malformed;
  }
  if (now.lost >= tell_lost_at_) {
    lines.push_back(fmt::format("source: {} readings so far were lost on their way, by the sender's count", now.lost));
    tell_lost_at_ = 10 * now.lost;
  }
  if (now.returns_alone && !told_.returns_alone)
    lines.emplace_back("source: lines end with a carriage return alone; end them with a line feed");
  if (now.readings == 0 && now.ignored >= tell_ignored_at_) {
    lines.push_back(fmt::format(
        "source: {} lines and no reading, the last {}; name what the columns hold with 'source: columns', or "
        "send a header line such as time_ms,acc_x_g,acc_y_g,acc_z_g,...{}",
        now.ignored, io::quote(now.refused.view()), hint(now.look)));
    tell_ignored_at_ = 100 * now.ignored;
  }
}

void SourceWatch::tell_noise(const SourceReport& now, std::vector<std::string>& lines) {
  const auto& [acc, gyr, mag] = now.noise;
  const bool first = told_.noise == pipeline::StatedNoise{};
  if (first && now.noise != told_.noise)
    lines.push_back(
        fmt::format("source: it states its noise, {:.3g} m/s^2, {:.3g} rad/s, {:.3g} uT a reading (0: not known); the "
                    "attitude is at least as unsure",
                    acc, gyr, mag));
  if (now.variances_refused < tell_variances_at_) return;
  tell_variances_at_ = 10 * now.variances_refused;
  const double variance = now.refused_variance;
  lines.push_back(fmt::format(
      "source: {} covariances refused so far, the last of the {}: a variance of {} is {}; what is configured serves",
      now.variances_refused,
      now.refused_part == kAcc   ? "accelerometer"
      : now.refused_part == kGyr ? "gyroscope"
                                 : "magnetometer",
      variance,
      !std::isfinite(variance) ? "no number"
      : variance < 0.0         ? "negative"
                               : "more than such a sensor can have"));
}

std::vector<std::string> SourceWatch::news(std::span<const Finding> findings) {
  std::vector<std::string> lines;
  if (const auto now = report_ != nullptr ? report_->try_load() : std::nullopt) {
    tell_link(*now, lines);
    tell_clock(*now, lines);
    tell_times(*now, lines);
    tell_names(*now, lines);
    tell_damage(*now, lines);
    tell_noise(*now, lines);
    told_ = *now;
  }
  trouble_.clear();
  implausible_ = false;
  for (const Finding& f : findings) {
    const std::string what = io::describe(f);
    bool& told = told_oddities_[static_cast<std::size_t>(f.oddity)];
    if (f.stands != told) lines.push_back((f.stands ? "IMPLAUSIBLE: " : "plausible again: ") + what);
    told = f.stands;
    const bool once =
        f.oddity == Oddity::kTimeBackward || f.oddity == Oddity::kTimeJumped || f.oddity == Oddity::kTimeStopped;
    if (!f.stands || once || implausible_) continue;
    implausible_ = true;
    trouble_ = what;
  }
  if (report_ != nullptr && told_.link != LinkState::kThere)
    trouble_ = !told_.error.view().empty()      ? io::printable(told_.error.view())
               : told_.link == LinkState::kGone ? "the sensor is gone; it is waited for"
                                                : "no sensor yet";
  if (!times_trouble_.empty()) trouble_ = times_trouble_;
  return lines;
}

}  // namespace stillpoint::app
