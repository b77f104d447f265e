/// Readings of the kernel's IIO devices, on this machine or through an iiod: several devices as one source.
#pragma once
#include <memory>

#include "io/source_config.h"
#include "pipeline/stage.h"
#include "sources/report.h"

namespace stillpoint::sources {

class IioSource {
 public:
  /// What is not there yet is waited for.
  IioSource(const io::IioParams& params, double reopen_at_most_s);
  ~IioSource();
  IioSource(IioSource&&) noexcept;
  IioSource& operator=(IioSource&&) noexcept;

  /// Blocks for at most 100 ms; no allocation. Each device is read by a thread of its own.
  pipeline::SourceState next(pipeline::Arrival& out) noexcept;
  [[nodiscard]] bool live() const noexcept { return true; }

  [[nodiscard]] ReportCell report() const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace stillpoint::sources
