// The way back over recordings of a simulator that is not ours: what is found goes into the simulation as a file, and a
// second diagnosis against that file finds no mismatch.
#include <gmock/gmock.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "diagnosis/diagnose.h"
#include "diagnosis/improved.h"
#include "io/recording.h"
#include "io/simulation_yaml.h"
#include "tests/source_folder.h"

namespace stillpoint::diag {
namespace {

namespace fs = std::filesystem;

/// 003: rests still differ once the sensitivity to force, found without a reference, is taken out; 036: 11 nats of the
/// 11000 that a resonance near the end of the camera's band explains are left.
const std::vector<std::string> kLeaveATrace{"003", "036"};

/// Every finding has a law and numbers that a simulation can run with.
bool all_named(const Diagnosis& d) {
  return !d.findings.empty() && std::none_of(d.findings.begin(), d.findings.end(), [](const Finding& f) {
    return is_unknown(f) || f.effect.ends_with("_drift");
  });
}

TEST(RoundTrip, ASecondDiagnosisFindsNoMissingPhysicsOnceTheFindingsAreInTheSimulation) {
  const fs::path cases = fs::path(in_source("../shared/blind_open/cases"));
  if (!fs::is_directory(cases)) GTEST_SKIP() << "LOUD: SKIPPED: " << cases << " is not there";
  std::vector<std::string> open;
  std::size_t named = 0;
  for (const auto& entry : fs::directory_iterator(cases)) {
    if (entry.path().extension() != ".csv") continue;
    const std::string id = entry.path().stem().string();
    const auto recording = io::read_recording(entry.path().string(), io::OnMalformedRow::kCount);
    const auto simulation = io::read_simulation((cases / (id + ".yaml")).string());
    ASSERT_TRUE(recording && simulation) << id;
    const Answer answer = diagnose(*recording, *simulation);
    if (!all_named(answer.diagnosis)) continue;
    ++named;
    const auto improved = io::parse_simulation(io::format_simulation(improved_by(answer, *simulation)), "improved");
    ASSERT_TRUE(improved) << id << ": " << improved.error().message;
    if (!diagnose(*recording, *improved).diagnosis.findings.empty()) open.push_back(id);
  }
  std::printf("round trip: %zu of %zu close\n", named - open.size(), named);
  EXPECT_GE(named, 20u);
  EXPECT_THAT(open, testing::IsSubsetOf(kLeaveATrace));
}

}  // namespace
}  // namespace stillpoint::diag
