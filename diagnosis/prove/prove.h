/// The proof on concealed data: cases drawn with known physics, sealed by a hash, solved by somebody who sees only the
/// recording and the baseline, then opened and scored. All cases count; none is dropped or drawn again.
#pragma once
#include <array>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/result.h"
#include "io/recording.h"
#include "simulation/config.h"

namespace stillpoint::diag {

/// What is known of a case by its maker only.
struct CaseTruth {
  std::string kind;       ///< clean, single, window, oneaxis, pair, confound, cfgerr, notemp, noaux, absorb,
                          ///< novel, deleted, noref, limit
  std::string reference;  ///< exact, mocap, none
  std::string noise;      ///< white, coloured, uneven, flicker
  std::map<std::string, std::map<std::string, std::vector<double>>> effects;  ///< ID to parameters by symbol
  std::optional<std::array<double, 2>> window_s;
  std::vector<std::string> allowed =
      {};                ///< names as true as the effects': of the noise that the simulation leaves out
  double d_prime = 0.0;  ///< of the weakest effect, in the sensor that sees it best; 0: not known
};

struct SealedCase {
  std::string id;
  CaseTruth truth;
  std::string nonce;
  io::Recording recording;           ///< what the solver gets,
  sim::SimulationConfig baseline;    ///< and against what
  std::vector<std::string> without;  ///< laws that the referee takes out of the solver's library: the true one
};

/// Where an effect acts on some axes only, the true number of each other axis is 0 (three numbers: one an axis).
void act_on_axes(std::map<std::string, std::vector<double>>& parameters, const std::vector<int>& axes);

[[nodiscard]] nlohmann::json to_json(const CaseTruth& truth);
/// From a truth file of a folder of cases. Fails (65) on anything that is not such a file.
[[nodiscard]] Result<CaseTruth> parse_truth(const std::string& text, const std::string& name);

/// SHA-256 of id, truth and nonce, newline between.
[[nodiscard]] std::string seal(const std::string& id, const CaseTruth& truth, const std::string& nonce);

/// What the sensors are like beside the physics that is concealed.
enum class Parts : std::uint8_t {
  kIdeal,  ///< as the simulation says
  kReal,   ///< flicker of which the simulation says nothing; 50, 100 or 200 Hz
};

/// Case `index` of the proof with this salt: the same salt gives the same recording. `quick` halves the length.
[[nodiscard]] SealedCase draw_case(const std::string& salt, std::size_t index, bool quick, Parts parts = Parts::kIdeal);

/// The same, all of one kind of CaseTruth::kind: a large sample of what is rare in a whole proof.
[[nodiscard]] SealedCase draw_case_of(const std::string& kind, const std::string& salt, std::size_t index, bool quick,
                                      Parts parts = Parts::kIdeal);
/// The kinds that a whole proof draws.
[[nodiscard]] std::vector<std::string> kinds_of_cases();

/// A weak effect alone, of a size about the detection limit, for limit_tables().
[[nodiscard]] SealedCase draw_limit_case(const std::string& salt, std::size_t index, bool quick,
                                         Parts parts = Parts::kIdeal);

/// True numbers of one effect: how many lie inside their stated 95 % interval.
struct Coverage {
  std::size_t inside = 0, stated = 0;
};

/// How one answer (stillpoint.diagnosis/1; null: the solver failed) stands against the truth.
struct CaseScore {
  std::string id;
  CaseTruth truth;
  std::string outcome;  ///< right, family, unknown, config, missed, wrong, failed
  std::vector<std::string> said;
  int untrue = 0;                            ///< findings whose name is not true
  bool both = false;                         ///< of a pair: both named
  double overlap = 0.0;                      ///< of the first finding's interval with the window
  std::map<std::string, Coverage> coverage;  ///< by effect
  std::optional<double> removed;             ///< share of the removable error, on held-out data
};
[[nodiscard]] CaseScore score_case(const std::string& id, const CaseTruth& truth, const nlohmann::json& answer);

/// Lower and upper 95 % bound of a rate (Wilson).
[[nodiscard]] std::array<double, 2> wilson95(std::size_t hits, std::size_t n);

/// The tables of the proof: rates with intervals, false alarms by noise, naming by d', confusion, coverage, all misses.
[[nodiscard]] std::string tables(const std::vector<CaseScore>& scores);
/// From which size on an effect is found and named in half of the cases, as a ratio to the size at which the likelihood
/// ratio test that knows the law finds it in half of them at 1 % false alarms.
[[nodiscard]] std::string limit_tables(const std::vector<CaseScore>& scores);
[[nodiscard]] nlohmann::json summary(const std::vector<CaseScore>& scores);

}  // namespace stillpoint::diag
