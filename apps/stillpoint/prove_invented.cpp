#include "apps/stillpoint/prove_invented.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <vector>

#include "apps/stillpoint/at_once.h"
#include "apps/stillpoint/child_process.h"
#include "apps/stillpoint/progress.h"
#include "diagnosis/prove/invented.h"
#include "diagnosis/prove/sha256.h"
#include "io/simulation_yaml.h"
#include "io/text_file.h"

namespace stillpoint::app {
namespace {

namespace fs = std::filesystem;

std::string file(const fs::path& room, const std::string& id, const char* ending) {
  return (room / (id + ending)).string();
}

/// Draws the case, has it solved by a process that sees its files only, opens and judges. The truth never leaves this
/// process.
diag::InventedScore solved(const diag::InventedCase& c, const fs::path& room) {
  sim::SimulationConfig given = c.baseline;
  given.motion.reset();
  given.environment = {};
  given.reference = {};
  diag::InventedScore failed;
  failed.clean = c.clean;
  if (!io::write_recording(c.recording, file(room, c.id, ".csv"))) return failed;
  if (!io::write_simulation(given, file(room, c.id, ".yaml"))) return failed;
  const std::string answer = file(room, c.id, ".json"), improved = file(room, c.id, "_improved.yaml");
  auto child = ChildProcess::start(
      {fs::read_symlink("/proc/self/exe").string(), "diagnose", "--simulation", file(room, c.id, ".yaml"),
       "--recording", file(room, c.id, ".csv"), "--json", answer, "--improved", improved},
      "/dev/null");
  if (child) child->wait();
  const auto simulation = io::read_simulation(improved);
  const auto json = nlohmann::json::parse(io::read_text_file(answer, "an answer (.json)").value_or(""), nullptr, false);
  if (!simulation || !json.is_object()) return failed;
  return diag::score_invented(c, *simulation, json);
}

std::string told(const diag::InventedCase& c, const diag::InventedScore& s) {
  const std::string said = s.said.empty() ? "nothing stated" : fmt::format("stated: {}", fmt::join(s.said, "; "));
  if (c.clean) return fmt::format("{}  clean: {}", c.id, said);
  return fmt::format("{}  {} {}  {:.1f} of the noise: R^2 {:.3f}{}; {}", c.id, c.sensor, c.law, c.rms_over_noise, s.r2,
                     s.drivers_right ? "" : ", other drivers", said);
}

}  // namespace

int prove_invented(const std::string& salt, std::size_t cases, bool quick, const fs::path& room) {
  std::vector<diag::InventedCase> all;
  const auto seal = [](const diag::InventedCase& c) {
    return diag::sha256(c.id + "\n" + diag::truth_of(c).dump() + "\n" + c.nonce);
  };
  std::vector<std::string> seals;
  for (std::size_t i = 0; i < cases; ++i) {
    all.push_back(diag::invent(salt, i, quick));
    seals.push_back(seal(all.back()));
    std::printf("%s  %s\n", all.back().id.c_str(), seals.back().c_str());
  }
  std::fflush(stdout);
  std::vector<diag::InventedScore> scores(cases);
  std::atomic<std::size_t> done{0};
  Progress progress("solving");
  at_once(cases, processors(), [&](std::size_t i) {
    scores[i] = solved(all[i], room);
    progress.at(static_cast<double>(++done) / static_cast<double>(cases));
  });
  bool sealed = true;
  for (std::size_t i = 0; i < cases; ++i) sealed = sealed && seal(all[i]) == seals[i];
  std::printf("\n%s\n", sealed ? "opened: every truth matches its seal" : "a truth does not match its seal");
  for (std::size_t i = 0; i < cases; ++i) std::printf("%s\n", told(all[i], scores[i]).c_str());
  std::printf("\n%s", diag::invented_table(scores).c_str());
  return sealed ? 0 : static_cast<int>(ErrorKind::kThreshold);
}

}  // namespace stillpoint::app
