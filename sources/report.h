/// What a live source has to tell: written by the sensor thread, read by whoever logs and publishes.
#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <string_view>

#include "core/snapshot_cell.h"
#include "pipeline/stage.h"
#include "sources/line_look.h"

namespace stillpoint::sources {

/// A text of bounded length that crosses between threads.
class ShortText {
 public:
  ShortText() = default;
  explicit ShortText(std::string_view text) noexcept : size_(std::min(text.size(), text_.size())) {
    std::copy_n(text.data(), size_, text_.begin());
  }
  [[nodiscard]] std::string_view view() const noexcept { return {text_.data(), size_}; }

 private:
  std::array<char, 240> text_{};
  std::size_t size_ = 0;
};

/// A source tells its counts so often at most, and a change of its link at once.
inline constexpr std::int64_t kTellPeriod_ns = 20'000'000;

enum class LinkState : std::uint8_t { kNeverThere, kThere, kGone };

struct SourceReport {
  LinkState link = LinkState::kNeverThere;
  std::uint64_t opened = 0;             ///< how often the device or the peer was there
  std::uint64_t failures = 0;           ///< attempts to open it that failed
  std::uint64_t readings = 0;           ///< handed on
  std::uint64_t malformed = 0;          ///< damaged lines, frames or messages
  std::uint64_t ignored = 0;            ///< texts and numbers that nobody can name
  std::uint64_t skipped_bytes = 0;      ///< that belong to no frame and to no line
  std::uint64_t lost = 0;               ///< missing by the sender's count
  std::uint64_t times_refused = 0;      ///< rows at a time that is none
  double refused_time = 0.0;            ///< of the last one, as it came
  double refused_time_unit_ns = 1.0;    ///< in which it came
  bool returns_alone = false;           ///< lines seem to end with a carriage return alone
  std::uint64_t unstamped = 0;          ///< without a time: of the second that teaches the rate, or damaged
  std::uint64_t began_anew = 0;         ///< senders whose stamps began anew after a pause of a stream that was not cut
  std::int64_t away_ns = 0;             ///< how long nothing had come the last time
  std::uint64_t variances_refused = 0;  ///< that no sensor can have
  SamplePart refused_part = kAcc;       ///< of the last one
  double refused_variance = 0.0;
  pipeline::StatedNoise noise;         ///< in use
  ShortText error;                     ///< why it could not be opened last
  ShortText refused;                   ///< the last line that was no reading
  LineLook look = LineLook::kUnknown;  ///< of lines that were no readings
  ShortText unknown_names;             ///< of columns or JSON fields that are no reading
  ShortText header_faults;             ///< where the header line does not fit what is configured, or lacks an axis
};

/// Shared between the source and its readers.
using ReportCell = std::shared_ptr<SnapshotCell<SourceReport>>;

}  // namespace stillpoint::sources
