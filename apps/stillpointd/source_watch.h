/// What the slow thread knows of the source: its link, its damage, and readings that cannot be right.
#pragma once
#include <array>
#include <span>
#include <string>
#include <vector>

#include "core/plausibility.h"
#include "sources/report.h"

namespace stillpoint::app {

class SourceWatch {
 public:
  /// `report` may be none: a replay has nothing to tell of itself.
  explicit SourceWatch(sources::ReportCell report) : report_(std::move(report)) {}

  /// What happened since the last call, one line an event. `findings` are the pipeline's, of all its samples so far.
  [[nodiscard]] std::vector<std::string> news(std::span<const Finding> findings);
  /// What keeps the readings from being used as they are, in one line; empty: nothing.
  [[nodiscard]] const std::string& trouble() const noexcept { return trouble_; }
  /// Units or readings are wrong as long as this sensor is there. A clock that was set once is no such thing.
  [[nodiscard]] bool implausible() const noexcept { return implausible_; }

 private:
  void tell_link(const sources::SourceReport& now, std::vector<std::string>& lines);
  void tell_clock(const sources::SourceReport& now, std::vector<std::string>& lines);
  void tell_times(const sources::SourceReport& now, std::vector<std::string>& lines);
  void tell_names(const sources::SourceReport& now, std::vector<std::string>& lines);
  void tell_damage(const sources::SourceReport& now, std::vector<std::string>& lines);
  void tell_noise(const sources::SourceReport& now, std::vector<std::string>& lines);

  sources::ReportCell report_;
  sources::SourceReport told_;
  std::string told_failure_;  ///< of the absence at hand
  std::uint64_t failures_when_there_ = 0;
  std::array<bool, kOddities> told_oddities_{};
  bool implausible_ = false;
  std::uint64_t tell_malformed_at_ = 1, tell_ignored_at_ = 100, tell_variances_at_ = 1, tell_lost_at_ = 1;
  std::uint64_t tell_times_at_ = 1;
  std::string times_trouble_;  ///< of rows that were refused since the last call
  std::string trouble_;
};

}  // namespace stillpoint::app
