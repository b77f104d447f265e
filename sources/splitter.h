/// Bytes of a stream into readings: lines or frames, whatever is cut, lost or put in between. No allocation but for a
/// header line and the first object of JSON.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "sources/frame.h"
#include "sources/line.h"
#include "sources/line_look.h"

namespace stillpoint::sources {

/// Counted since the start.
struct SplitCounts {
  std::uint64_t readings = 0;
  std::uint64_t malformed = 0;        ///< lines or frames that were damaged
  std::uint64_t ignored = 0;          ///< comments, texts, blank lines, numbers before any header
  std::uint64_t skipped_bytes = 0;    ///< between frames, and of lines too long to be one
  std::uint64_t lost = 0;             ///< missing by the frames' counter
  std::uint64_t times_refused = 0;    ///< readings at a time that is none
  double refused_time = 0.0;          ///< of the last one, as it came
  double refused_time_unit_ns = 1.0;  ///< in which it came
  bool returns_alone = false;         ///< lines seem to end with a carriage return
};

class Splitter {
 public:
  explicit Splitter(const io::StreamParams& params)
      : format_(params), configured_(params.format), frames_(params.format) {}

  /// Room for what arrives next; `received` says how much of it was filled. Never empty once `next` gave kNone.
  [[nodiscard]] std::span<std::uint8_t> room() noexcept { return std::span(buffer_).subspan(end_); }
  void received(std::size_t bytes) noexcept {
    end_ += bytes;
    unseen_ = true;
  }
  /// What was received last stands for itself (a datagram): a line needs no line feed there.
  void end_of_datagram() noexcept;

  /// The next reading, or kNone when more bytes are needed. `steps` is by how much the sender's count went on: more
  /// than 1 where something was lost or damaged.
  Piece next(Reading& out, std::uint64_t& steps) noexcept;

  /// After a cut: what was there is forgotten. `in_midst`: the first line may have lost its head.
  void restart(bool in_midst) noexcept;

  [[nodiscard]] const SplitCounts& counts() const noexcept { return counts_; }
  /// The last line that was no reading, cut to what is worth showing.
  [[nodiscard]] std::string_view last_refused() const noexcept { return {refused_.data(), refused_size_}; }
  /// What the header line, or the first object of JSON, names that is no reading.
  [[nodiscard]] const std::string& unknown_names() const noexcept { return unknown_names_; }
  /// Where the header line does not fit what is configured, or lacks an axis.
  [[nodiscard]] const std::string& header_faults() const noexcept { return header_faults_; }
  /// What the lines that were no readings look like, as far as that was seen.
  [[nodiscard]] LineLook look() const noexcept { return look_; }
  [[nodiscard]] bool knows_positions() const noexcept { return format_.knows_positions(); }

 private:
  Piece next_line(Reading& out) noexcept;
  void note_names(Piece piece, std::string_view line) noexcept;
  Piece next_frame(Reading& out, std::uint64_t& steps) noexcept;
  bool text_has_frames() noexcept;
  void drop(std::size_t bytes) noexcept { begin_ += bytes; }
  void compact() noexcept;
  void refuse(std::string_view line) noexcept;
  [[nodiscard]] std::span<const std::uint8_t> unread() const noexcept {
    return std::span(buffer_).subspan(begin_, end_ - begin_);
  }

  LineFormat format_;
  io::StreamFormat configured_, frames_;
  std::array<std::uint8_t, 8192> buffer_{};
  std::size_t begin_ = 0, end_ = 0;
  SplitCounts counts_;
  std::array<char, 60> refused_{};
  std::size_t refused_size_ = 0;
  std::string unknown_names_, header_faults_;
  LineLook look_ = LineLook::kUnknown;
  std::uint64_t damaged_ = 0;  ///< since the last reading
  bool unseen_ = false, skip_line_ = false, counter_known_ = false, overlong_ = false;
  bool object_seen_ = false;
  std::uint8_t counter_ = 0;
};

}  // namespace stillpoint::sources
