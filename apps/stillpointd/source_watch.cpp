#include "apps/stillpointd/source_watch.h"

#include <fmt/format.h>

#include <algorithm>

#include "io/plausibility_text.h"
#include "io/quote.h"

namespace stillpoint::app {

using sources::LinkState;
using sources::SourceReport;

void SourceWatch::tell_link(const SourceReport& now, std::vector<std::string>& lines) {
  const bool failed = now.failures > told_.failures && now.error.view() != told_.error.view();
  if (now.link != LinkState::kThere && failed)
    lines.push_back(fmt::format("source: {}; it is tried again", io::printable(now.error.view())));
  if (now.link == told_.link) return;
  if (now.link == LinkState::kGone) lines.emplace_back("source: gone; it is waited for");
  if (now.link != LinkState::kThere) return;
  const bool again = told_.link == LinkState::kGone;
  lines.push_back(fmt::format("source: there{}", again ? " again" : ""));
  if (!again) return;  // of a short stream all readings may have been judged before its link is looked at
  check_ = {};         // another sensor, or the same with another range
  told_findings_ = 0;
}

void SourceWatch::tell_damage(const SourceReport& now, std::vector<std::string>& lines) {
  if (now.malformed >= tell_malformed_at_) {
    lines.push_back(fmt::format("source: {} damaged lines or frames so far, {} lost by the sender's count, the last {}",
                                now.malformed, now.lost, io::quote(now.refused.view())));
    tell_malformed_at_ = 10 * now.malformed;
  }
  if (now.readings == 0 && now.ignored >= tell_ignored_at_) {
    lines.push_back(fmt::format(
        "source: {} lines and no reading, the last {}; name what the columns hold with 'source: columns', or "
        "send a header line such as time_ms,acc_x_g,acc_y_g,acc_z_g,...",
        now.ignored, io::quote(now.refused.view())));
    tell_ignored_at_ = 100 * now.ignored;
  }
}

const Finding* SourceWatch::lasting() const noexcept {
  const auto findings = check_.findings();
  const auto found = std::find_if(findings.begin(), findings.end(), [](const Finding& f) {
    return f.oddity != Oddity::kTimeBackward && f.oddity != Oddity::kTimeJumped && f.oddity != Oddity::kTimeStopped;
  });
  return found == findings.end() ? nullptr : &*found;
}

std::vector<std::string> SourceWatch::news() {
  std::vector<std::string> lines;
  if (const auto now = report_ != nullptr ? report_->try_load() : std::nullopt) {
    tell_link(*now, lines);
    tell_damage(*now, lines);
    told_ = *now;
  }
  const auto findings = check_.findings();
  for (; told_findings_ < findings.size(); ++told_findings_)
    lines.push_back("IMPLAUSIBLE: " + io::describe(findings[told_findings_]));
  if (report_ != nullptr && told_.link != LinkState::kThere)
    trouble_ = told_.error.view().empty() ? "no sensor yet" : io::printable(told_.error.view());
  else
    trouble_ = lasting() != nullptr ? io::describe(*lasting()) : "";
  return lines;
}

}  // namespace stillpoint::app
