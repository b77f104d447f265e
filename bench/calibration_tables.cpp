/// Prints every calibration figure of docs/calibration.md: paper beside ours. Usage: calibration_tables [PART...]
/// [--recordings DIR] with PART of gietzelt, zhang, worn, day, alignment, rest, recordings; all when none is named.
#include "bench/calibration_tables.h"

#include <cstdio>
#include <set>

int main(int argc, char** argv) {
  using namespace stillpoint::bench;
  std::string recordings = std::string(STILLPOINT_SOURCE_DIR) + "/../shared/recordings";
  std::set<std::string> parts;
  for (int k = 1; k < argc; ++k) {
    if (std::string(argv[k]) == "--recordings" && k + 1 < argc)
      recordings = argv[++k];
    else
      parts.insert(argv[k]);
  }
  const auto wanted = [&parts](const char* part) { return parts.empty() || parts.count(part) > 0; };
  if (wanted("gietzelt")) gietzelt_tables();
  if (wanted("zhang")) zhang_tables();
  if (wanted("worn")) worn_and_adjusted();
  if (wanted("day")) simulated_day();
  if (wanted("alignment")) alignment_and_gyro();
  if (wanted("rest")) rest_detection();
  if (wanted("recordings")) real_recordings(recordings);
  return 0;
}
