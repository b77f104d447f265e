/// The daemon's sources: what the configuration names, paced, behind the fault injector.
#pragma once
#include <memory>
#include <variant>

#include "core/result.h"
#include "io/config.h"
#include "pipeline/fault_injector.h"
#include "pipeline/sources.h"
#include "simulation/simulator.h"

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
  explicit AnySource(S source) : source_(std::make_unique<Variant>(std::move(source))) {}
  pipeline::SourceState next(pipeline::Arrival& out) noexcept {
    return std::visit([&out](auto& source) { return source.next(out); }, *source_);
  }

 private:
  using Variant = std::variant<pipeline::MemorySource, SimulatorSource>;
  std::unique_ptr<Variant> source_;  // moved once, at the start, by its pointer
};

using DaemonSource = pipeline::FaultInjector<pipeline::PacedSource<AnySource>>;

/// Fails as the readers do: 66 no such file, 65 bad recording, 78 bad simulation or a simulation without motion.
[[nodiscard]] Result<DaemonSource> open_source(const io::SourceConfig& config);

}  // namespace stillpoint::app
