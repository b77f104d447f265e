#include "io/dds_admission.h"

#include <algorithm>

namespace stillpoint::io {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;
// A program seldom has more than two participants, each with a socket of its own to send from; a start of a robot's
// whole system brings some hundred programs at once.
constexpr int kBurstOfOne = 4, kBurstOfAll = 128;
constexpr std::int64_t kRefillOfOne_ns = kSecond_ns, kRefillOfAll_ns = kSecond_ns / 10;

}  // namespace

bool Admission::Bucket::take(std::int64_t now_ns, std::int64_t refill_ns, int burst) noexcept {
  const std::int64_t missing_ns = std::max<std::int64_t>(0, full_at_ns - now_ns);
  if (missing_ns + refill_ns > burst * refill_ns) return false;
  full_at_ns = now_ns + missing_ns + refill_ns;
  return true;
}

bool Admission::is_known(const GuidPrefix& participant, std::int64_t now_ns) noexcept {
  const auto found = std::find_if(known_.begin(), known_.end(),
                                  [&](const Known& one) { return one.seen_ns != 0 && one.participant == participant; });
  if (found == known_.end()) return false;
  found->seen_ns = now_ns;
  return true;
}

/// The one that was silent longest makes room: it asks anew when it comes back.
void Admission::remember(const GuidPrefix& participant, std::int64_t now_ns) noexcept {
  *std::min_element(known_.begin(), known_.end(),
                    [](const Known& a, const Known& b) { return a.seen_ns < b.seen_ns; }) = {participant, now_ns};
}

/// A source that has used nothing lately makes room. Where all have, the newcomer shares the bucket that is filled up
/// soonest.
Admission::Bucket& Admission::bucket_of(std::uint64_t source, std::int64_t now_ns) noexcept {
  const auto own = std::find_if(sources_.begin(), sources_.end(), [&](const Bucket& b) { return b.source == source; });
  if (own != sources_.end()) return *own;
  auto& freest = *std::min_element(sources_.begin(), sources_.end(),
                                   [](const Bucket& a, const Bucket& b) { return a.full_at_ns < b.full_at_ns; });
  if (freest.full_at_ns <= now_ns) freest = {source, now_ns};
  return freest;
}

bool Admission::admit(const GuidPrefix& participant, std::uint64_t source, std::int64_t now_ns) noexcept {
  const std::lock_guard lock(mutex_);
  if (is_known(participant, now_ns)) return true;
  if (!bucket_of(source, now_ns).take(now_ns, kRefillOfOne_ns, kBurstOfOne) ||
      !all_.take(now_ns, kRefillOfAll_ns, kBurstOfAll))
    return false;
  remember(participant, now_ns);
  return true;
}

}  // namespace stillpoint::io
