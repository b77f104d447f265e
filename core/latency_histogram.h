/// Distribution of a latency at a fixed cost: 640 buckets, each at most 1/16 wide relative to its value, from 1 ns to
/// 2^42 ns. The form of Tene's HdrHistogram: below 16 ns one bucket a nanosecond, above it 16 buckets an octave.
#pragma once
#include <array>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

namespace stillpoint {

inline constexpr std::size_t kLatencyBuckets = 640;

/// Bucket of a latency; negative ones (clock of another machine) go to the first, too large ones to the last.
constexpr std::size_t latency_bucket(std::int64_t ns) noexcept {
  if (ns < 16) return ns < 0 ? 0 : static_cast<std::size_t>(ns);
  const auto octave = static_cast<unsigned>(std::bit_width(static_cast<std::uint64_t>(ns))) - 5U;  // 0 for 16..31
  const auto bucket = static_cast<std::size_t>(16U * octave) + static_cast<std::size_t>(ns >> octave);
  return bucket < kLatencyBuckets ? bucket : kLatencyBuckets - 1;
}

/// Smallest latency of a bucket, ns.
constexpr std::int64_t latency_bucket_lower_ns(std::size_t bucket) noexcept {
  if (bucket < 32) return static_cast<std::int64_t>(bucket);
  const auto octave = (bucket - 16) / 16;
  return static_cast<std::int64_t>(bucket - 16 * octave) << octave;
}

using LatencyCounts = std::array<std::uint64_t, kLatencyBuckets>;

/// Latency in ns below which the share `p` (0..1) of the counts lies: the upper edge of the bucket, so never
/// flattering. 0 without counts.
inline std::int64_t latency_percentile_ns(std::span<const std::uint64_t> counts, double p) noexcept {
  std::uint64_t total = 0;
  for (const std::uint64_t n : counts) total += n;
  if (total == 0) return 0;
  const double wanted = p * static_cast<double>(total);
  std::uint64_t below = 0;
  std::size_t bucket = 0;
  for (; bucket < counts.size(); ++bucket) {
    below += counts[bucket];
    if (below > 0 && static_cast<double>(below) >= wanted) break;
  }
  return latency_bucket_lower_ns(bucket + 1);
}

/// Filled by one thread, read by any. Wait-free, no read-modify-write: one writer needs none.
class LatencyHistogram {
 public:
  void add(std::int64_t ns) noexcept {
    auto& count = counts_[latency_bucket(ns)];
    count.store(count.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
    if (ns > max_ns_.load(std::memory_order_relaxed)) max_ns_.store(ns, std::memory_order_relaxed);
  }
  [[nodiscard]] LatencyCounts counts() const noexcept {
    LatencyCounts copy{};
    for (std::size_t i = 0; i < kLatencyBuckets; ++i) copy[i] = counts_[i].load(std::memory_order_relaxed);
    return copy;
  }
  [[nodiscard]] std::int64_t max_ns() const noexcept { return max_ns_.load(std::memory_order_relaxed); }

 private:
  std::array<std::atomic<std::uint64_t>, kLatencyBuckets> counts_{};
  std::atomic<std::int64_t> max_ns_{0};
};

}  // namespace stillpoint
