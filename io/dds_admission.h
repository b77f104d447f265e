/// How many new participants are let in, and how fast. Each costs Fast DDS memory, sends and locks that the publisher's
/// subscribers wait for; a flood of them must cost the one who floods.
#pragma once
#include <array>
#include <cstdint>
#include <mutex>

#include "io/dds_rtps.h"

namespace stillpoint::io {

class Admission {
 public:
  /// Whether the announcement of this participant, from this address and port, may be handed on now. One that is known
  /// always may; one that may not is judged anew at its next announcement. Allocation-free.
  bool admit(const GuidPrefix& participant, std::uint64_t source, std::int64_t now_ns) noexcept;

 private:
  /// Refills with time, up to its burst.
  struct Bucket {
    std::uint64_t source = 0;
    std::int64_t full_at_ns = 0;  ///< the tokens that are missing, as time
    bool take(std::int64_t now_ns, std::int64_t refill_ns, int burst) noexcept;
  };
  struct Known {
    GuidPrefix participant{};
    std::int64_t seen_ns = 0;
  };
  bool is_known(const GuidPrefix& participant, std::int64_t now_ns) noexcept;
  void remember(const GuidPrefix& participant, std::int64_t now_ns) noexcept;
  Bucket& bucket_of(std::uint64_t source, std::int64_t now_ns) noexcept;

  std::mutex mutex_;  // taken for announcements only, not for data
  std::array<Known, 512> known_{};
  std::array<Bucket, 64> sources_{};
  Bucket all_;
};

}  // namespace stillpoint::io
