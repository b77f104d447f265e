#include "sources/stamps.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace stillpoint::sources {
namespace {

constexpr double kLearn_ns = 1e9;
constexpr std::uint64_t kLeastToLearn = 4;
constexpr double kTimeConstant_ns = 1e9;
/// Later than this, and by more than a few periods, nothing came for a while: the phase is taken anew.
constexpr double kLongPause_ns = 0.25e9;
constexpr double kPausePeriods = 4.0;
/// Sensors in rows of their own come late by no more: a time that lies further behind is of a clock that was set.
constexpr double kLatestReading_ns = 0.5e9;
/// A sender that began anew was away for longer, and longer than a few usual arrivals.
constexpr double kAway_ns = 0.1e9;
constexpr double kAwayArrivals = 4.0;
constexpr double kCounts32 = 4294967296.0;
constexpr std::int64_t kFurthest_ns = 4'000'000'000'000'000'000;  // 126 years: the difference of two still fits

}  // namespace

bool ArrivalClock::learn(std::int64_t arrival_ns, std::uint64_t steps) noexcept {
  if (!started_) {
    started_ = true;
    epoch_ns_ = arrival_ns;
    learnt_ = 0;
    return false;
  }
  learnt_ += steps;
  const auto elapsed_ns = static_cast<double>(arrival_ns - epoch_ns_);
  if (elapsed_ns < kLearn_ns || learnt_ < kLeastToLearn) return false;
  period_ns_ = elapsed_ns / static_cast<double>(learnt_);
  return true;
}

bool ArrivalClock::stamp(std::int64_t arrival_ns, std::uint64_t steps, std::int64_t& t_ns) noexcept {
  if (period_ns_ <= 0.0 && !learn(arrival_ns, steps)) return false;
  double due_ns = next_ns_ + static_cast<double>(steps - 1) * period_ns_;
  double late_ns = static_cast<double>(arrival_ns - epoch_ns_) - due_ns;
  if (!locked_ || std::abs(late_ns) > std::max(kLongPause_ns, kPausePeriods * period_ns_)) {
    const bool again = locked_;
    locked_ = true;
    epoch_ns_ = arrival_ns;
    due_ns = late_ns = 0.0;
    if (again && last_ns_ >= arrival_ns) due_ns = static_cast<double>(last_ns_ - arrival_ns) + period_ns_;
  }
  const double gain = 1.0 - std::exp(-period_ns_ / kTimeConstant_ns);
  due_ns += gain * late_ns;
  // A quarter of the squared gain damps the loop critically.
  period_ns_ = std::max(1.0, period_ns_ + 0.25 * gain * gain * late_ns);
  next_ns_ = due_ns + period_ns_;
  t_ns = std::max<std::int64_t>(epoch_ns_ + std::llround(due_ns), last_ns_ + 1);
  last_ns_ = t_ns;
  return true;
}

void Stamps::restart() noexcept {
  restarted_ = true;
  device_time_ = false;
  suspect_.reset();
  for (ArrivalClock& clock : clocks_) clock.restart();
}

std::int64_t Stamps::unwrapped(const Reading& reading) noexcept {
  std::int64_t t_ns = reading.sample.t_ns + offset_ns_;
  const double back_ns = static_cast<double>(last_ns_) - static_cast<double>(t_ns);
  const double wrap_ns = kCounts32 * reading.time_unit_ns;
  // A 32-bit counter of ms, us or ns begins at 0 again; nothing else goes back by just about that much.
  const bool wrapped = wrap_ns < 1e16 && back_ns > 0.9 * wrap_ns && back_ns < 1.1 * wrap_ns;
  // A row of its own from before that end may come after it: the counter has not gone round twice.
  if (wrapped_ns_ && static_cast<double>(last_ns_ - *wrapped_ns_) < kLatestReading_ns) {
    const double before_ns = static_cast<double>(*wrapped_ns_) + wrap_ns - static_cast<double>(t_ns);
    if (before_ns > 0.0 && before_ns < kLatestReading_ns) return t_ns - static_cast<std::int64_t>(wrap_ns);
  }
  if (!wrapped || offset_ns_ > kFurthest_ns - static_cast<std::int64_t>(wrap_ns)) return t_ns;
  offset_ns_ += static_cast<std::int64_t>(wrap_ns);
  wrapped_ns_ = t_ns + static_cast<std::int64_t>(wrap_ns);
  return *wrapped_ns_;
}

void Stamps::follow(std::int64_t sender_ns, std::int64_t due_ns, std::int64_t& t_ns) noexcept {
  const std::int64_t offset_ns = due_ns - sender_ns;
  if (std::abs(offset_ns) >= kFurthest_ns) return;
  t_ns += offset_ns - offset_ns_;
  offset_ns_ = offset_ns;
}

/// A time that lies behind is the pipeline's affair while readings come (a clock was set, and no time is missing).
/// After a pause it is a sender that began anew, and only arrivals tell how long that took; the second such reading
/// proves it. True: wait for that one. A replay that is faster than real time has no such pauses.
bool Stamps::suspects(std::int64_t sender_ns, std::int64_t& t_ns, std::int64_t arrival_ns) noexcept {
  const auto suspect = std::exchange(suspect_, std::nullopt);
  if (static_cast<double>(last_ns_) - static_cast<double>(t_ns) <= kLatestReading_ns) return false;
  if (suspect) {
    if (std::abs(static_cast<double>(sender_ns - suspect->sender_ns)) > kLatestReading_ns) return false;
    follow(suspect->sender_ns, last_ns_ + suspect->away_ns, t_ns);
    away_ns_ = suspect->away_ns;
    ++began_anew_;
    return false;
  }
  const std::int64_t away_ns = arrival_ns - last_arrival_ns_;
  if (static_cast<double>(away_ns) <= std::max(kAway_ns, kAwayArrivals * arrivals_.ns())) return false;
  suspect_ = {sender_ns, away_ns};
  return true;
}

bool Stamps::stamp(Reading& reading, std::int64_t arrival_ns, std::uint64_t steps) noexcept {
  RawSample& sample = reading.sample;
  if (!reading.has_time) {
    if (device_time_) return false;  // the others have one: this one is damaged
    return clocks_[sample.has & 15U].stamp(arrival_ns, steps, sample.t_ns);
  }
  if (std::abs(sample.t_ns) > kFurthest_ns) return false;
  std::int64_t t_ns = ever_ ? unwrapped(reading) : sample.t_ns;
  if (ever_ && restarted_ && t_ns <= last_ns_)
    follow(sample.t_ns, last_ns_ + std::max<std::int64_t>(1, arrival_ns - last_arrival_ns_), t_ns);
  else if (ever_ && !restarted_ && suspects(sample.t_ns, t_ns, arrival_ns))
    return false;
  if (std::abs(t_ns) > kFurthest_ns) return false;  // a sum beyond it: the next one would not fit
  if (ever_ && arrival_ns > last_arrival_ns_) arrivals_.learn(arrival_ns - last_arrival_ns_);
  restarted_ = false;
  device_time_ = ever_ = true;
  sample.t_ns = last_ns_ = t_ns;
  last_arrival_ns_ = arrival_ns;
  return true;
}

}  // namespace stillpoint::sources
