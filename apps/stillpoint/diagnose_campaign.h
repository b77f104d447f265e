/// `stillpoint diagnose` with several recordings of one sensor: one answer for all of them.
#pragma once
#include <string>
#include <vector>

namespace stillpoint::app {

struct CampaignOptions {
  std::vector<std::string> recordings, without;
  std::string simulation, json, improved;
  bool quiet = false, fail_on_mismatch = false;
};

/// The exit code.
int diagnose_campaign(const CampaignOptions& options);

}  // namespace stillpoint::app
