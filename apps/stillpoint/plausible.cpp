#include "apps/stillpoint/plausible.h"

#include "apps/stillpoint/outcome.h"
#include "io/plausibility_text.h"

namespace stillpoint::app {

std::vector<Finding> warn_if_implausible(const io::Recording& recording, const std::string& path) {
  auto findings = io::find_implausible(recording);
  for (const auto& finding : findings) tell("stillpoint: warning: " + path + ": " + io::describe(finding));
  return findings;
}

}  // namespace stillpoint::app
