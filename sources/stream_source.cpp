#include "sources/stream_source.h"

#include <algorithm>

#include "pipeline/clock.h"

namespace stillpoint::sources {
namespace {

constexpr int kPatience_ms = 100;

}  // namespace

Result<StreamSource> StreamSource::create(const io::StreamParams& params, double reopen_at_most_s) {
  auto address = parse_address(params.from);
  if (!address) return tl::unexpected(address.error());
  return StreamSource(std::move(*address), params, reopen_at_most_s);
}

StreamSource::StreamSource(Address address, const io::StreamParams& params, double reopen_at_most_s)
    : splitter_(std::make_unique<Splitter>(params)),
      endpoint_(std::move(address), params.baud),
      stamps_(params.rate_hz),
      reopening_(reopen_at_most_s),
      report_(std::make_shared<SnapshotCell<SourceReport>>()) {
  tell(LinkState::kNeverThere);
}

pipeline::SourceState StreamSource::next(pipeline::Arrival& out) noexcept {
  using pipeline::SourceState;
  if (parsed(out)) return SourceState::kSample;
  if (!endpoint_.is_open() && !open_again()) return was_there_ ? SourceState::kGone : SourceState::kNothing;
  std::size_t bytes = 0;
  switch (endpoint_.read(splitter_->room(), kPatience_ms, bytes)) {
    case ReadState::kBytes:
      arrival_ns_ = monotonic_ns();
      splitter_->received(bytes);
      if (endpoint_.datagrams()) splitter_->end_of_datagram();
      was_there_ = true;
      reopening_.works();
      if (parsed(out)) return SourceState::kSample;
      if (arrival_ns_ - told_ns_ > kTellPeriod_ns) tell(counts_.link);  // of lines that are no readings
      return SourceState::kNothing;
    case ReadState::kNothing:
      tell(counts_.link);
      return SourceState::kNothing;
    case ReadState::kClosed:
      return lost(SourceState::kGone);
    default:
      return lost(SourceState::kEnd);
  }
}

bool StreamSource::parsed(pipeline::Arrival& out) noexcept {
  Reading reading;
  std::uint64_t steps = 1;
  while (splitter_->next(reading, steps) == Piece::kReading) {
    if (!stamps_.stamp(reading, arrival_ns_, steps)) {
      ++counts_.unstamped;
      continue;
    }
    sequence_ += steps;
    out.sample = reading.sample;
    out.sample.sequence = sequence_;
    out.arrival_ns = arrival_ns_;
    ++counts_.readings;
    if (arrival_ns_ - told_ns_ > kTellPeriod_ns || counts_.link != LinkState::kThere) tell(LinkState::kThere);
    return true;
  }
  return false;
}

bool StreamSource::open_again() noexcept {
  const std::int64_t now_ns = monotonic_ns();
  if (!reopening_.due(now_ns)) {
    pipeline::sleep_until_ns(std::min(reopening_.next_ns(), now_ns + std::int64_t{kPatience_ms} * 1'000'000));
    return false;
  }
  const auto opened = endpoint_.open();
  if (!opened) {
    reopening_.failed(now_ns);
    ++counts_.failures;
    counts_.error = ShortText(opened.error().message);
    tell(was_there_ ? LinkState::kGone : LinkState::kNeverThere);
    return false;
  }
  ++counts_.opened;
  splitter_->restart(endpoint_.joins_in_midst());
  return true;
}

pipeline::SourceState StreamSource::lost(pipeline::SourceState state) noexcept {
  endpoint_.close();
  splitter_->restart(false);
  stamps_.restart();
  reopening_.failed(monotonic_ns());
  tell(state == pipeline::SourceState::kEnd ? counts_.link : LinkState::kGone);
  return state;
}

void StreamSource::tell(LinkState link) noexcept {
  const SplitCounts& split = splitter_->counts();
  counts_.link = link;
  counts_.malformed = split.malformed;
  counts_.ignored = split.ignored;
  counts_.skipped_bytes = split.skipped_bytes;
  counts_.lost = split.lost;
  counts_.times_refused = split.times_refused;
  counts_.refused_time = split.refused_time;
  counts_.refused_time_unit_ns = split.refused_time_unit_ns;
  counts_.returns_alone = split.returns_alone;
  counts_.began_anew = stamps_.began_anew();
  counts_.away_ns = stamps_.away_ns();
  counts_.refused = ShortText(splitter_->last_refused());
  counts_.look = splitter_->look();
  counts_.unknown_names = ShortText(splitter_->unknown_names());
  counts_.header_faults = ShortText(splitter_->header_faults());
  report_->store(counts_);
  told_ns_ = monotonic_ns();
}

}  // namespace stillpoint::sources
