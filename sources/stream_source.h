/// Readings from lines or frames that come through standard input, a FIFO, a serial line or a socket.
#pragma once
#include <memory>

#include "io/source_config.h"
#include "pipeline/stage.h"
#include "sources/endpoint.h"
#include "sources/reopening.h"
#include "sources/report.h"
#include "sources/splitter.h"
#include "sources/stamps.h"

namespace stillpoint::sources {

class StreamSource {
 public:
  /// Fails (78) on an address that is none. What is not there yet is waited for.
  [[nodiscard]] static Result<StreamSource> create(const io::StreamParams& params, double reopen_at_most_s);

  /// Blocks for at most 100 ms; allocates only to open and for a header line.
  pipeline::SourceState next(pipeline::Arrival& out) noexcept;
  [[nodiscard]] bool live() const noexcept { return true; }

  [[nodiscard]] ReportCell report() const noexcept { return report_; }

 private:
  StreamSource(Address address, const io::StreamParams& params, double reopen_at_most_s);
  bool parsed(pipeline::Arrival& out) noexcept;
  bool open_again() noexcept;
  pipeline::SourceState lost(pipeline::SourceState state) noexcept;
  void tell(LinkState link) noexcept;

  std::unique_ptr<Splitter> splitter_;  // its buffer is not moved about
  Endpoint endpoint_;
  Stamps stamps_;
  Reopening reopening_;
  ReportCell report_;
  SourceReport counts_;
  std::uint64_t sequence_ = 0;
  std::int64_t arrival_ns_ = 0, told_ns_ = 0;
  bool was_there_ = false;
};

}  // namespace stillpoint::sources
