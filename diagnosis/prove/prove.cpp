#include "diagnosis/prove/prove.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "diagnosis/finding_effect.h"
#include "diagnosis/prove/sha256.h"

namespace stillpoint::diag {
namespace {

using Json = nlohmann::json;

/// Laws of one sensor that are nearly one another: naming the neighbour is not right, but not untrue either.
const std::vector<std::vector<std::string>> kFamilies{{"temp_lin", "temp_quad", "temp_lag", "temp_scale"},
                                                      {"lpf", "delay", "resonance"},
                                                      {"lever", "size"},
                                                      {"quad", "vre", "asym"},
                                                      {"cubic", "sat"},
                                                      {"hard_step", "field_step", "soft_step"},
                                                      {"drift", "instability"}};
const std::vector<std::string> kDelays{"acc_delay", "gyr_delay", "mag_delay", "sys_offset", "sys_gap", "sys_skew"};

bool family(const std::string& a, const std::string& b) {
  if (a == b || (contains(kDelays, a) && contains(kDelays, b))) return true;
  const auto split = [](const std::string& id) {
    return std::pair{id.substr(0, id.find('_')), id.substr(id.find('_') + 1)};
  };
  const std::pair first = split(a), second = split(b);
  return first.first == second.first && std::any_of(kFamilies.begin(), kFamilies.end(), [&](const auto& f) {
           return contains(f, first.second) && contains(f, second.second);
         });
}

struct Stated {
  std::string effect;
  std::vector<std::string> names;  ///< with at most two equivalents
  Json finding;
};

/// Where the driver is not in the recording, or an estimator absorbed it, a random walk is an honest word for "slow".
std::vector<Stated> stated(const Json& answer, const CaseTruth& truth) {
  std::vector<Stated> all;
  const bool hidden = truth.kind == "notemp" || truth.kind == "noaux" || truth.kind == "absorb";
  for (const auto& f : answer.value("findings", Json::array())) {
    Stated s{f.value("effect", ""), {}, f};
    if (hidden && s.effect.ends_with("_drift") && !truth.effects.contains(s.effect)) s.effect = "unknown:" + s.effect;
    if (contains(truth.allowed, s.effect) && !truth.effects.contains(s.effect)) continue;
    s.names.push_back(s.effect);
    const auto equivalent = f.value("equivalent", std::vector<std::string>{});
    for (std::size_t i = 0; i < std::min<std::size_t>(2, equivalent.size()); ++i) s.names.push_back(equivalent[i]);
    all.push_back(std::move(s));
  }
  return all;
}

bool names_true(const Stated& s, const CaseTruth& truth) {
  return std::any_of(s.names.begin(), s.names.end(), [&](const auto& n) { return truth.effects.contains(n); });
}
bool names_family(const Stated& s, const CaseTruth& truth) {
  return std::any_of(s.names.begin(), s.names.end(), [&](const auto& n) {
    return std::any_of(truth.effects.begin(), truth.effects.end(), [&](const auto& t) { return family(n, t.first); });
  });
}

std::string outcome_of(const std::vector<Stated>& said, const Json& answer, const CaseTruth& truth) {
  if (said.empty()) {
    if (answer.value("verdict", "") == "unexplained") return "unknown";
    return answer.value("configuration", Json::array()).empty() ? "missed" : "config";
  }
  if (said[0].effect.starts_with("unknown")) return "unknown";
  if (names_true(said[0], truth)) return "right";
  return names_family(said[0], truth) ? "family" : "wrong";
}

/// Compares each true number with the interval stated for it: "k" with "k_x" ..., "G" with "G_xx" ....
void score_intervals(const Json& finding, const std::map<std::string, std::vector<double>>& truth, Coverage& score) {
  static const char* kAxes = "xyz";
  std::map<std::string, std::array<double, 2>> interval;
  for (const auto& p : finding.value("parameters", Json::array()))
    if (p.contains("ci95") && p["ci95"].size() == 2 && p["ci95"][0].is_number() && p["ci95"][1].is_number())
      interval[p.value("name", "")] = {p["ci95"][0].get<double>(), p["ci95"][1].get<double>()};
  for (const auto& [symbol, values] : truth) {
    for (std::size_t i = 0; i < values.size(); ++i) {
      std::string name = symbol;
      if (values.size() == 3) name += fmt::format("_{}", kAxes[i]);
      if (values.size() == 9) name += fmt::format("_{}{}", kAxes[i / 3], kAxes[i % 3]);
      const auto at = interval.find(name);
      if (at == interval.end()) continue;
      ++score.stated;
      score.inside += at->second[0] <= values[i] && values[i] <= at->second[1];
    }
  }
}

}  // namespace

void act_on_axes(std::map<std::string, std::vector<double>>& parameters, const std::vector<int>& axes) {
  if (axes.empty()) return;
  for (auto& [symbol, values] : parameters)
    for (std::size_t i = 0; i < values.size() && values.size() == 3; ++i)
      if (std::find(axes.begin(), axes.end(), static_cast<int>(i)) == axes.end()) values[i] = 0.0;
}

Json to_json(const CaseTruth& t) {
  Json j{
      {"kind", t.kind}, {"reference", t.reference}, {"noise", t.noise}, {"effects", t.effects}, {"d_prime", t.d_prime}};
  if (!t.allowed.empty()) j["allowed"] = t.allowed;
  j["window"] = t.window_s ? Json(*t.window_s) : Json(nullptr);
  return j;
}

Result<CaseTruth> parse_truth(const std::string& text, const std::string& name) {
  const Json j = Json::parse(text, nullptr, false);
  const auto bad = [&](const char* what) { return fail(ErrorKind::kBadData, fmt::format("{}: {}", name, what)); };
  if (!j.is_object() || !j.contains("kind") || !j["kind"].is_string())
    return bad("no truth of a case: \"kind\" is missing");
  if (!j.contains("effects") || !j["effects"].is_object()) return bad("no truth of a case: \"effects\" is missing");
  CaseTruth t;
  t.kind = j["kind"].get<std::string>();
  t.reference = j.contains("reference") && j["reference"].is_string() ? j["reference"].get<std::string>() : "";
  t.noise = "as made";
  for (const auto& [id, parameters] : j["effects"].items()) {
    auto& out = t.effects[id];
    for (const auto& [symbol, values] : parameters.items())
      for (const auto& v : values.is_array() ? values : Json::array({values}))
        for (const auto& x : v.is_array() ? v : Json::array({v}))
          if (x.is_number()) out[symbol].push_back(x.get<double>());
  }
  if (j.contains("axes") && j["axes"].is_object())
    for (const auto& [id, axis] : j["axes"].items())
      if (t.effects.contains(id) && axis.is_number_integer()) act_on_axes(t.effects[id], {axis.get<int>()});
  if (j.contains("allowed") && j["allowed"].is_array())
    for (const auto& id : j["allowed"])
      if (id.is_string()) t.allowed.push_back(id.get<std::string>());
  if (j.contains("window") && j["window"].is_array() && j["window"].size() == 2 && j["window"][0].is_number() &&
      j["window"][1].is_number())
    t.window_s = {j["window"][0].get<double>(), j["window"][1].get<double>()};
  return t;
}

std::string seal(const std::string& id, const CaseTruth& truth, const std::string& nonce) {
  return sha256(id + "\n" + to_json(truth).dump() + "\n" + nonce);
}

CaseScore score_case(const std::string& id, const CaseTruth& truth, const Json& answer) {
  CaseScore score;
  score.id = id;
  score.truth = truth;
  score.outcome = "failed";
  if (!answer.is_object()) return score;
  const auto said = stated(answer, truth);
  score.outcome = outcome_of(said, answer, truth);
  for (const auto& s : said) {
    score.said.push_back(s.effect);
    score.untrue += !s.effect.starts_with("unknown") && !names_family(s, truth);
  }
  score.both =
      truth.effects.size() >= 2 && std::all_of(truth.effects.begin(), truth.effects.end(), [&](const auto& t) {
        return std::any_of(said.begin(), said.end(), [&](const Stated& s) { return contains(s.names, t.first); });
      });
  for (const Stated& s : said) {
    const auto at = truth.effects.find(s.effect);
    if (at == truth.effects.end()) continue;
    const Json& finding = s.finding;
    score_intervals(finding, at->second, score.coverage[at->first]);
    const Json h = finding.value("held_out", Json::object());
    const double before = h.value("rms_before", 0.0), after = h.value("rms_after", 0.0),
                 floor = h.value("noise_floor", 0.0);
    if (!score.removed && before > 1.02 * floor && floor > 0)
      score.removed = (before * before - after * after) / (before * before - floor * floor);
    if (truth.window_s && finding.contains("interval_s") && finding["interval_s"].size() == 2) {
      const double a = finding["interval_s"][0].get<double>(), b = finding["interval_s"][1].get<double>();
      const double both = std::max(0.0, std::min(b, (*truth.window_s)[1]) - std::max(a, (*truth.window_s)[0]));
      score.overlap = both / (std::max(b, (*truth.window_s)[1]) - std::min(a, (*truth.window_s)[0]));
    }
  }
  return score;
}

std::array<double, 2> wilson95(std::size_t hits, std::size_t n) {
  if (n == 0) return {0.0, 1.0};
  constexpr double z = 1.959964;
  const double k = static_cast<double>(hits), m = static_cast<double>(n), p = k / m;
  const double centre = p + z * z / (2 * m), half = z * std::sqrt(p * (1 - p) / m + z * z / (4 * m * m));
  return {std::max(0.0, (centre - half) / (1 + z * z / m)), std::min(1.0, (centre + half) / (1 + z * z / m))};
}

}  // namespace stillpoint::diag
