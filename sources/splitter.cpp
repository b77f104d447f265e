#include "sources/splitter.h"

#include <algorithm>
#include <cstring>

namespace stillpoint::sources {
namespace {

/// Of columns, and not what a device says as it starts.
bool looks_like_names(std::string_view line) noexcept {
  const auto separates = [](char c) { return c == ',' || c == ';' || c == '\t'; };
  return std::count_if(line.begin(), line.end(), separates) >= 3 && line.find(':') == std::string_view::npos;
}

}  // namespace

void Splitter::restart(bool in_midst) noexcept {
  begin_ = end_ = 0;
  frames_ = configured_;
  skip_line_ = in_midst;
  counter_known_ = overlong_ = false;
}

void Splitter::end_of_datagram() noexcept {
  if (end_ == begin_ || end_ == buffer_.size() || buffer_[end_ - 1] == '\n' || buffer_[begin_] == kSync[0]) return;
  buffer_[end_++] = '\n';
}

void Splitter::compact() noexcept {
  if (begin_ == 0) return;
  std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
  end_ -= begin_;
  begin_ = 0;
}

void Splitter::refuse(std::string_view line) noexcept {
  refused_size_ = std::min(line.size(), refused_.size());
  std::copy_n(line.data(), refused_size_, refused_.data());
  if (const LineLook look = look_of(line); look != LineLook::kUnknown) look_ = look;
}

/// 0xA5 never stands in a text: once a whole frame was seen, frames it is.
bool Splitter::text_has_frames() noexcept {
  const auto bytes = unread();
  for (std::size_t at = 0; at < bytes.size(); ++at) {
    if (bytes[at] != kSync[0]) continue;
    const Frame frame = take_frame(bytes.subspan(at));
    if (frame.piece != Piece::kReading) continue;
    counts_.skipped_bytes += at;
    drop(at);
    return true;
  }
  return false;
}

Piece Splitter::next(Reading& out, std::uint64_t& steps) noexcept {
  if (frames_ == io::StreamFormat::kAuto && unseen_ && text_has_frames()) frames_ = io::StreamFormat::kFrames;
  unseen_ = false;
  Piece piece = Piece::kNone;
  do {
    steps = 1;
    piece = frames_ == io::StreamFormat::kFrames ? next_frame(out, steps) : next_line(out);
    if (piece == Piece::kMalformed) ++counts_.malformed, ++damaged_;
    if (piece == Piece::kIgnored || piece == Piece::kHeader) ++counts_.ignored;
    if (piece == Piece::kTimeRefused) {
      ++counts_.times_refused, ++damaged_;
      counts_.refused_time = out.refused_time;
      counts_.refused_time_unit_ns = out.time_unit_ns;
    }
  } while (piece != Piece::kReading && piece != Piece::kNone);
  if (piece == Piece::kReading) {
    ++counts_.readings;
    if (frames_ != io::StreamFormat::kFrames) steps += damaged_;  // a frame's counter tells by itself
    damaged_ = 0;
  } else {
    compact();
  }
  return piece;
}

Piece Splitter::next_line(Reading& out) noexcept {
  const auto bytes = unread();
  const auto* found = static_cast<const std::uint8_t*>(std::memchr(bytes.data(), '\n', bytes.size()));
  if (found == nullptr) {
    if (bytes.size() == buffer_.size()) {  // no line is that long: wait for the next one
      counts_.skipped_bytes += bytes.size();
      counts_.returns_alone = std::memchr(bytes.data(), '\r', bytes.size()) != nullptr;
      drop(bytes.size());
      overlong_ = true;
    }
    return Piece::kNone;
  }
  const auto length = static_cast<std::size_t>(found - bytes.data());
  const std::string_view line(reinterpret_cast<const char*>(bytes.data()), length);
  drop(length + 1);
  if (overlong_) {
    overlong_ = false;
    refuse(line);
    return Piece::kMalformed;
  }
  Piece piece = format_.parse(line, out);
  note_names(piece, line);
  // The head of the first line may be missing, and a number without its first digits is a number still.
  if (skip_line_ && piece != Piece::kHeader && line.substr(0, 1) != "{") piece = Piece::kIgnored;
  skip_line_ = false;
  if (piece == Piece::kMalformed || (piece == Piece::kIgnored && length > 1)) refuse(line);
  return piece;
}

void Splitter::note_names(Piece piece, std::string_view line) noexcept {
  const bool object = piece != Piece::kMalformed && line.substr(0, 1) == "{";
  const bool used = piece == Piece::kHeader ? format_.use_header(line) : object && !object_seen_;
  const bool names = piece == Piece::kHeader && looks_like_names(line);
  if (used || (names && !knows_positions())) unknown_names_ = format_.unknown_names(line);
  if (piece == Piece::kHeader && (used || (names && (format_.configured() || !knows_positions()))))
    header_faults_ = format_.header_faults(line);
  object_seen_ = object_seen_ || object;
}

Piece Splitter::next_frame(Reading& out, std::uint64_t& steps) noexcept {
  const Frame frame = take_frame(unread());
  drop(frame.size);
  if (frame.piece == Piece::kMalformed) {
    counts_.skipped_bytes += frame.size;
    return frame.piece;
  }
  if (frame.piece != Piece::kReading) return frame.piece;
  if (counter_known_) steps = static_cast<std::uint8_t>(frame.counter - counter_);
  if (steps == 0) steps = 256;  // the same counter again: a whole round was lost, or the sender began anew
  counts_.lost += steps - 1;
  counter_ = frame.counter;
  counter_known_ = true;
  out = frame.reading;
  return Piece::kReading;
}

}  // namespace stillpoint::sources
