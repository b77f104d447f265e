/// Laws that nobody listed, drawn by a referee: random expressions with memory, regimes, named columns and decoys. The
/// generator is its own and wider than the grammar in which the diagnosis searches (smooth saturation, two lags in a
/// row, ratios), so it shares no code with it.
#pragma once
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "io/recording.h"
#include "simulation/config.h"

namespace stillpoint::diag {

struct InventedCase {
  std::string id, nonce;
  bool clean = false;
  std::string law;                 ///< in words of the referee; empty: clean
  std::string sensor;              ///< acc, gyr, mag
  std::set<std::string> drivers;   ///< w, f, m, T, V, I, t, or a column's name
  double rms_over_noise = 0.0;     ///< with bias and matrix projected out
  io::Recording recording;         ///< what the solver gets,
  sim::SimulationConfig baseline;  ///< and against what
  io::Recording fresh;             ///< another motion of the same sensor, exact reference and no noise
  std::vector<Vec3> fresh_delta;   ///< what the law does there
};

/// The same salt gives the same case; every fourth is clean.
[[nodiscard]] InventedCase invent(const std::string& salt, std::size_t index, bool quick);
[[nodiscard]] nlohmann::json truth_of(const InventedCase& c);

struct InventedScore {
  bool clean = false, drivers_right = false;
  std::vector<std::string> said;  ///< the effects that were stated, unknown ones too; steps of readings are none
  double r2 = 0.0;  ///< share of the law's power on fresh motion that the improved simulation has, bias and matrix free
};

/// `improved`: the simulation that the solver wrote; `answer`: its JSON (null: it failed).
[[nodiscard]] InventedScore score_invented(const InventedCase& c, const sim::SimulationConfig& improved,
                                           const nlohmann::json& answer);
[[nodiscard]] std::string invented_table(const std::vector<InventedScore>& scores);

}  // namespace stillpoint::diag
