#include "diagnosis/discovery/law_words.h"

#include <algorithm>

#include "diagnosis/discovery/table_term.h"
#include "simulation/law_effect.h"

namespace stillpoint::diag {
namespace {

constexpr std::string_view kUnknown = "unknown:";

bool uses(const laws::Node& n, laws::Op op) {
  return n.op == op || std::any_of(n.args.begin(), n.args.end(), [op](const auto& a) { return uses(a, op); });
}

struct Mechanism {
  std::string sensor;                ///< empty: any
  std::vector<std::string> drivers;  ///< exactly these
  std::optional<laws::Op> with;      ///< and this operation
  std::string words;
};

const std::vector<Mechanism>& mechanisms() {
  using enum laws::Op;
  static const std::vector<Mechanism> all{
      {"", {"T"}, kRate, "stress of the package while it warms: follows the rate of temperature, not its value"},
      {"", {"T"}, kLag, "heat that reaches the element later than the thermometer"},
      {"", {"T"}, std::nullopt, "temperature coefficient of the offset, of higher order than the data sheet's"},
      {"", {"I"}, kLag, "self-heating or stress by a load that is switched: settles with the body it warms"},
      {"mag", {"I"}, std::nullopt, "field of a conductor; squared: force or heat of the current"},
      {"", {"I"}, std::nullopt, "supply drop, ground shift or stress by the load"},
      {"", {"V"}, std::nullopt, "supply sensitivity of the offset"},
      {"gyr", {"T", "w"}, std::nullopt, "scale factor that follows temperature; with |w|: heating of the drive loop"},
      {"gyr", {"V", "w"}, std::nullopt, "scale factor that is ratiometric to the supply"},
      {"acc", {"V", "f"}, std::nullopt, "scale factor that is ratiometric to the supply"},
      {"gyr",
       {"f", "w"},
       std::nullopt,
       "mount or proof mass that bends under force: g-sensitivity of the scale factor"},
      {"acc", {"f", "w"}, kRate, "flexing mount: the arm from the turning point changes with force"},
      {"gyr", {"w"}, kSign, "drive electronics with hysteresis or dead band"},
      {"gyr", {"w"}, std::nullopt, "nonlinear or cross-axis scale factor of the rate loop"},
      {"acc", {"f"}, kSin, "integral nonlinearity of the converter: periodic along its range"},
      {"gyr", {"w"}, kSin, "integral nonlinearity of the converter: periodic along its range"},
      {"acc", {"f"}, std::nullopt, "cross-axis product of the proof mass: axes couple under force"},
      {"acc", {"w"}, std::nullopt, "point of sensing away from the turning point"},
      {"mag", {"m"}, kPlay, "hysteresis of soft iron near the sensor"},
      {"mag", {"m"}, kRate, "eddy currents in a conductor near the sensor"},
      {"mag", {"w", "m"}, std::nullopt, "eddy currents in a conductor that turns with the sensor"},
      {"", {"t"}, kStep, "something that changed at one moment: a shock, a part added, a setting"},
      {"", {"t"}, kExp, "settling after power-on or after mounting"},
      {"", {"t"}, kLog, "creep of an adhesive or of the package"},
      {"", {"t"}, std::nullopt, "ageing, or a driver that is not in the recording"},
  };
  return all;
}

}  // namespace

std::vector<std::string> mechanisms_of(const laws::Node& law, const std::string& sensor) {
  std::vector<std::string> drivers = laws::drivers_of(law), out;
  std::sort(drivers.begin(), drivers.end());
  for (const Mechanism& m : mechanisms()) {
    std::vector<std::string> wanted = m.drivers;
    std::sort(wanted.begin(), wanted.end());
    if ((m.sensor.empty() || m.sensor == sensor) && wanted == drivers && (!m.with || uses(law, *m.with)))
      out.push_back(m.words);
  }
  if (out.size() > 2) out.resize(2);
  return out;
}

std::string law_text(const std::string& effect) {
  // Where a driver's zero lies, bias and matrix take up.
  static const std::vector<std::pair<std::string, std::string>> kWords{
      {"(T-T0)", "(T - 25)"}, {"(V-V0)", "(V - 3.7)"},
      {"|w|", "norm(w)"},     {"|f|", "(norm(f) - 9.81)"},
      {"dw/dt_", "d(w)_"},    {"dw/dt", "d(w)"},
      {"|w_i|", "abs(w)"},    {"|f_i|", "abs(f)"},
      {"|m_i|", "abs(m)"},    {"*", " * "}};
  std::string text = effect.substr(kUnknown.size());
  if (driver_of_table(text)) return text;
  if (sim::tree_of({.id = std::string(sim::kLawPrefix) + text, .parameters = {}, .axes = {}, .window_s = {}}))
    return text;
  for (const auto& [engine, grammar] : kWords)
    for (std::size_t at = text.find(engine); at != std::string::npos; at = text.find(engine, at + grammar.size()))
      text.replace(at, engine.size(), grammar);
  return text;
}

std::optional<laws::Node> law_tree(const std::string& effect) {
  if (!effect.starts_with(kUnknown)) return std::nullopt;
  const std::string said = law_text(effect), text = driver_of_table(said).value_or(said);
  auto tree = laws::parse(text, sim::signature_for(text));
  return tree ? std::optional(std::move(*tree)) : std::nullopt;
}

bool is_a_window_itself(const std::string& effect) {
  const std::size_t moment = effect.find("step(t,");
  if (moment == std::string::npos || !law_tree(effect)) return false;
  return effect.find("step(") < moment || effect.rfind("step(") > moment;
}

std::optional<nlohmann::ordered_json> law_json(const Finding& finding) {
  const auto tree = law_tree(finding.effect);
  if (!tree) return std::nullopt;
  const std::string sensor = finding.channels.empty() ? "" : finding.channels.front().substr(0, 3);
  auto weighed = nlohmann::ordered_json::array();
  for (const WeighedLaw& w : finding.weighed)
    weighed.push_back({{"text", w.text}, {"bits", w.bits}, {"gain_nats", w.gain_nats}, {"net_nats", w.net_nats}});
  return nlohmann::ordered_json{
      {"text", law_text(finding.effect)},           {"unit", laws::text(tree->unit)},
      {"drivers", laws::drivers_of(*tree)},         {"complexity_bits", laws::complexity_bits(*tree)},
      {"mechanisms", mechanisms_of(*tree, sensor)}, {"weighed", weighed}};
}

}  // namespace stillpoint::diag
