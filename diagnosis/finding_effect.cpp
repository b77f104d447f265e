#include "diagnosis/finding_effect.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "diagnosis/discovery/law_words.h"
#include "diagnosis/discovery/table_term.h"
#include "simulation/effect_catalogue.h"
#include "simulation/law_effect.h"

namespace stillpoint::diag {
namespace {

/// What the examination of raw values calls by the words of data sheets, in the symbols of the catalogue.
std::string symbol_of(const std::string& name) {
  static const std::vector<std::pair<std::string, std::string>> kSheet{
      {"lsb", "q"}, {"level", "L"}, {"rate", "fraction"}};
  for (const auto& [word, symbol] : kSheet)
    if (name.starts_with(word)) return symbol + name.substr(word.size());
  return name;
}

struct Numbers {
  std::vector<double> values;
  std::vector<int> axes;  ///< those that were found, where one number an axis is due and not all were
};

int axis_of(char letter) { return letter == 'x' ? 0 : letter == 'y' ? 1 : letter == 'z' ? 2 : -1; }

/// The numbers of one parameter: alone, or with the letters of its axes behind the last underscore. Two rails of one
/// axis (+ and -) are one level: the wider.
std::optional<Numbers> numbers_of(const Finding& f, const sim::EffectParameter& p) {
  std::vector<double> found(static_cast<std::size_t>(p.count), std::nan(""));
  for (const Parameter& q : f.parameters) {
    const std::string name = symbol_of(q.name);
    if (!name.starts_with(p.symbol)) continue;
    std::string axes = name.substr(p.symbol.size());
    if (axes.empty()) std::fill(found.begin(), found.end(), q.value);
    std::erase_if(axes, [](char c) { return c == '_' || c == '+' || c == '-'; });
    int at = 0;
    for (const char letter : axes) at = axis_of(letter) < 0 ? p.count : 3 * at + axis_of(letter);
    if (axes.empty() || at >= p.count) continue;
    double& slot = found[static_cast<std::size_t>(at)];
    slot = p.symbol == "L" ? std::max(std::isnan(slot) ? 0.0 : slot, std::abs(q.value)) : q.value;
  }
  Numbers out{found, {}};
  double any = std::nan("");
  for (int i = 0; i < p.count; ++i)
    if (const double v = found[static_cast<std::size_t>(i)]; !std::isnan(v)) any = v, out.axes.push_back(i);
  if (std::isnan(any)) return std::nullopt;
  for (double& v : out.values)
    if (std::isnan(v)) v = any;  // of an axis that the entry does not act on
  if (p.count != 3 || out.axes.size() == 3) out.axes.clear();
  return out;
}

}  // namespace

std::optional<sim::EffectConfig> effect_of(const Finding& finding) {
  const sim::EffectInfo* info = sim::find_effect(finding.effect);
  if (info == nullptr) return std::nullopt;
  sim::EffectConfig e;
  e.id = finding.effect;
  for (const auto& p : info->parameters) {
    const auto numbers = numbers_of(finding, p);
    if (!numbers && p.required) return std::nullopt;
    if (!numbers) continue;
    e.parameters[p.key] = numbers->values;
    if (!numbers->axes.empty()) e.axes = numbers->axes;
  }
  return e;
}

bool is_entry_of(const sim::EffectConfig& entry, const Finding& finding) {
  if (entry.id == finding.effect) return true;
  if (!is_unknown(finding) || (!sim::is_law(entry) && !sim::is_table(entry)) || entry.sensors.size() != 1) return false;
  const bool its_sensor =
      !finding.channels.empty() && finding.channels.front().starts_with(sim::prefix(entry.sensors.front()));
  const std::string text = law_text(finding.effect);
  return its_sensor && sim::expression_of(entry) == driver_of_table(text).value_or(text);
}

bool same_numbers(const sim::EffectConfig& a, const sim::EffectConfig& b) {
  constexpr double kSameNumbers = 0.1;  // of the size of an effect
  if (a.id != b.id) return false;
  return std::all_of(b.parameters.begin(), b.parameters.end(), [&a](const auto& p) {
    const auto at = a.parameters.find(p.first);
    if (at == a.parameters.end() || at->second.size() != p.second.size()) return false;
    const auto n = static_cast<Eigen::Index>(p.second.size());
    const Eigen::Map<const Eigen::VectorXd> x(at->second.data(), n), y(p.second.data(), n);
    return (x - y).norm() < kSameNumbers * x.norm();
  });
}

bool contains(const std::vector<sim::EffectConfig>& entries, const std::string& id) {
  return std::any_of(entries.begin(), entries.end(), [&id](const auto& e) { return e.id == id; });
}

bool contains(const std::vector<Finding>& findings, const std::string& id) {
  return std::any_of(findings.begin(), findings.end(), [&id](const Finding& f) { return f.effect == id; });
}

bool contains(const std::vector<std::string>& ids, const std::string& id) {
  return std::find(ids.begin(), ids.end(), id) != ids.end();
}

}  // namespace stillpoint::diag
