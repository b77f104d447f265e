/// What the slow thread knows of the source: its link, its damage, and readings that cannot be right.
#pragma once
#include <string>
#include <vector>

#include "core/plausibility.h"
#include "sources/report.h"

namespace stillpoint::app {

class SourceWatch {
 public:
  /// `report` may be none: a replay has nothing to tell of itself.
  explicit SourceWatch(sources::ReportCell report) : report_(std::move(report)) {}

  void on_sample(const RawSample& sample) noexcept { check_.push(sample); }
  /// What happened since the last call, one line an event.
  [[nodiscard]] std::vector<std::string> news();
  /// What keeps the readings from being used as they are, in one line; empty: nothing.
  [[nodiscard]] const std::string& trouble() const noexcept { return trouble_; }
  /// Units or readings are wrong as long as this sensor is there. A clock that was set once is no such thing.
  [[nodiscard]] bool implausible() const noexcept { return lasting() != nullptr; }

 private:
  [[nodiscard]] const Finding* lasting() const noexcept;
  void tell_link(const sources::SourceReport& now, std::vector<std::string>& lines);
  void tell_damage(const sources::SourceReport& now, std::vector<std::string>& lines);

  sources::ReportCell report_;
  sources::SourceReport told_;
  PlausibilityCheck check_;
  std::size_t told_findings_ = 0;
  std::uint64_t tell_malformed_at_ = 1, tell_ignored_at_ = 100;
  std::string trouble_;
};

}  // namespace stillpoint::app
