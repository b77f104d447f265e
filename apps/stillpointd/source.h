/// The daemon's source: what the configuration names, mounted, paced where it paces itself, behind the fault injector.
#pragma once
#include <memory>
#include <utility>
#include <variant>

#include "core/result.h"
#include "io/config.h"
#include "pipeline/fault_injector.h"
#include "pipeline/sources.h"
#include "simulation/simulator.h"
#include "sources/iio_source.h"
#include "sources/mounted.h"
#include "sources/ros2_source.h"
#include "sources/stream_source.h"

namespace stillpoint::app {

class SimulatorSource {
 public:
  explicit SimulatorSource(sim::Simulator simulator) : simulator_(std::move(simulator)) {}
  pipeline::SourceState next(pipeline::Arrival& out) noexcept {
    if (!simulator_.next(row_)) return pipeline::SourceState::kEnd;
    out.sample = row_.sample;
    out.arrival_ns = monotonic_ns();
    return pipeline::SourceState::kSample;
  }

 private:
  sim::Simulator simulator_;
  sim::SimulatedSample row_;
};

/// Any of the sources; a new one is one more alternative.
class AnySource {
 public:
  template <pipeline::Source S>
  explicit AnySource(S source, sources::ReportCell report = nullptr)
      : source_(std::make_unique<Variant>(std::move(source))), report_(std::move(report)) {}
  pipeline::SourceState next(pipeline::Arrival& out) noexcept {
    return std::visit([&out](auto& source) { return source.next(out); }, *source_);
  }
  [[nodiscard]] bool live() const noexcept {
    return std::visit([](const auto& source) { return pipeline::is_live(source); }, *source_);
  }
  /// None: the source has nothing to tell.
  [[nodiscard]] const sources::ReportCell& report() const noexcept { return report_; }

 private:
  using Variant = std::variant<pipeline::MemorySource, SimulatorSource, sources::StreamSource, sources::Ros2Source,
                               sources::IioSource>;
  std::unique_ptr<Variant> source_;  // moved once, at the start, by its pointer
  sources::ReportCell report_;
};

class DaemonSource {
 public:
  DaemonSource(AnySource source, const io::SourceConfig& config)
      : report_(source.report()),
        chain_({{std::move(source), config.mount}, config.live() ? 0.0 : config.speed},
               config.faults.value_or(pipeline::FaultParams{})) {}
  pipeline::SourceState next(pipeline::Arrival& out) noexcept { return chain_.next(out); }
  void prepare() noexcept { chain_.prepare(); }
  [[nodiscard]] bool live() const noexcept { return chain_.live(); }
  [[nodiscard]] const sources::ReportCell& report() const noexcept { return report_; }

 private:
  sources::ReportCell report_;
  pipeline::FaultInjector<pipeline::PacedSource<sources::Mounted<AnySource>>> chain_;
};

/// Fails as the readers do: 66 no such file, 65 bad recording, 78 bad simulation or a simulation without motion. A live
/// source that is not there yet is no failure: it is waited for.
[[nodiscard]] Result<DaemonSource> open_source(const io::DaemonConfig& config);

}  // namespace stillpoint::app
