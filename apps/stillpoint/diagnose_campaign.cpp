#include "apps/stillpoint/diagnose_campaign.h"

#include <fmt/format.h>

#include <atomic>
#include <cstdio>

#include "apps/stillpoint/at_once.h"
#include "apps/stillpoint/outcome.h"
#include "apps/stillpoint/plausible.h"
#include "diagnosis/campaign/campaign.h"
#include "io/recording.h"
#include "io/simulation_yaml.h"
#include "io/text_file.h"

namespace stillpoint::app {
namespace {

/// Each by itself, as many at once as there are processors.
void diagnose_parts(const sim::SimulationConfig& simulation, const std::vector<std::string>& without,
                    std::vector<diag::CampaignPart>& parts) {
  std::atomic<std::size_t> done{0};
  at_once(parts.size(), processors(), [&](std::size_t i) {
    parts[i].answer = diag::diagnose(*parts[i].recording, simulation, without);
    tell(fmt::format("{} of {}: {}", ++done, parts.size(), parts[i].file));
  });
}

}  // namespace

int diagnose_campaign(const CampaignOptions& o) {
  const auto simulation = io::read_simulation(o.simulation);
  if (!simulation) return report(simulation.error());
  std::vector<io::Recording> recordings;
  recordings.reserve(o.recordings.size());  // the parts point at them
  std::vector<diag::CampaignPart> parts;
  for (const std::string& file : o.recordings) {
    auto recording = io::read_recording(file, io::OnMalformedRow::kCount);
    if (!recording) return report(recording.error());
    warn_if_implausible(*recording, file);
    recordings.push_back(std::move(*recording));
    parts.push_back({file, &recordings.back(), {}});
  }
  diagnose_parts(*simulation, o.without, parts);
  const diag::Campaign campaign = diag::join(parts, *simulation);
  if (!o.quiet) std::fputs(diag::to_text(campaign, parts).c_str(), stdout);
  if (!o.improved.empty())
    if (const auto done = io::write_simulation(diag::improved_by(campaign, *simulation), o.improved); !done)
      return report(done.error());
  if (!o.json.empty())
    if (const auto done = io::write_text_file(o.json, diag::to_json(campaign, parts)); !done)
      return report(done.error());
  const bool mismatch = !campaign.effects.empty() || !campaign.own.empty();
  return o.fail_on_mismatch && mismatch ? static_cast<int>(ErrorKind::kThreshold) : 0;
}

}  // namespace stillpoint::app
