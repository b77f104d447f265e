/// A campaign as text for a person and as JSON for a program.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "diagnosis/answer_words.h"
#include "diagnosis/campaign/campaign.h"
#include "diagnosis/summary.h"

namespace stillpoint::diag {
namespace {

using nlohmann::json;

std::vector<std::string> files(const std::vector<std::size_t>& which, const std::vector<CampaignPart>& parts) {
  std::vector<std::string> out;
  for (const std::size_t i : which) out.push_back(parts[i].file);
  return out;
}

/// Without the folders, which the first lines have.
std::string short_name(const std::string& file) { return std::filesystem::path(file).filename().string(); }

std::string listed(const std::vector<std::size_t>& which, const std::vector<CampaignPart>& parts) {
  std::vector<std::string> names = files(which, parts);
  for (std::string& name : names) name = short_name(name);
  return fmt::format("{}", fmt::join(names, ", "));
}

std::vector<std::size_t> others(const std::vector<std::size_t>& which, std::size_t all) {
  std::vector<std::size_t> out;
  for (std::size_t i = 0; i < all; ++i)
    if (std::find(which.begin(), which.end(), i) == which.end()) out.push_back(i);
  return out;
}

std::string parameters_text(const SharedEffect& e) {
  std::string out;
  for (std::size_t k = 0; k < e.pooled.parameters.size(); ++k) {
    out += parameter_text(e.pooled.parameters[k]);
    if (e.found_in.size() > 1) out += fmt::format("   (chi-square {:.1f} of {})", e.chi2[k], e.found_in.size() - 1);
    out += "\n";
  }
  return out;
}

std::string effect_text(const SharedEffect& e, const std::vector<CampaignPart>& parts) {
  const bool alone = e.found_in.size() == 1;
  std::string out = alone ? fmt::format("\nALONE    {}: in {}\n", e.pooled.effect, listed(e.found_in, parts))
                          : fmt::format("\nSHARED   {}: in {} of {} recordings ({})\n", e.pooled.effect,
                                        e.found_in.size(), parts.size(), listed(e.found_in, parts));
  if (!e.pooled.equation.empty()) out += fmt::format("PHYSICS  {}\n", e.pooled.equation);
  out += parameters_text(e);
  if (const auto silent = others(e.found_in, parts.size()); !alone && !silent.empty())
    out += fmt::format("SILENT   {}\n", listed(silent, parts));
  if (!e.apart.empty())
    out +=
        fmt::format("DIFFERS  {}: further from what the others say than chance takes them\n", listed(e.apart, parts));
  if (e.contradicted)
    out += "DENIED   it makes a recording worse that does not show it; not in the improved simulation\n";
  else if (!e.confirmed)
    out += "OPEN     no other recording shows it or is explained by it; not in the improved simulation\n";
  return out;
}

}  // namespace

std::string to_text(const Campaign& c, const std::vector<CampaignPart>& parts) {
  std::string out;
  for (const CampaignPart& p : parts)
    out += fmt::format("RECORDING {}: {}  [{}]\n", p.file, p.answer.diagnosis.summary,
                       verdict_word(p.answer.diagnosis.verdict));
  for (const SharedEffect& e : c.effects) out += effect_text(e, parts);
  if (c.effects.empty()) out += "\nSHARED   nothing\n";
  out += "\n";
  for (const std::string& line : c.own) out += "OWN      " + line + "\n";
  for (const Validation& v : c.by_others) {
    const std::string name = short_name(v.file);
    out += std::isfinite(v.share)
               ? fmt::format(
                     "OTHERS   of {} {}, {:.3g} of the removable residual goes by what the others say ({:.3g} to "
                     "{:.3g})\n",
                     name, v.sensor, v.share, v.ci95[0], v.ci95[1])
               : fmt::format("OTHERS   of {} {} there is nothing to remove\n", name, v.sensor);
  }
  return wrapped(out);
}

std::string to_json(const Campaign& c, const std::vector<CampaignPart>& parts) {
  json out{{"schema", "stillpoint.campaign/1"}, {"recordings", json::array()}, {"effects", json::array()}};
  for (const CampaignPart& p : parts)
    out["recordings"].push_back({{"file", p.file},
                                 {"verdict", verdict_word(p.answer.diagnosis.verdict)},
                                 {"summary", p.answer.diagnosis.summary}});
  for (const SharedEffect& e : c.effects) {
    json parameters = json::array();
    for (std::size_t k = 0; k < e.pooled.parameters.size(); ++k) {
      parameters.push_back(parameter_json(e.pooled.parameters[k]));
      parameters.back()["chi2"] = number(e.chi2[k]);
    }
    out["effects"].push_back({{"effect", e.pooled.effect},
                              {"channels", e.pooled.channels},
                              {"found_in", files(e.found_in, parts)},
                              {"differs", files(e.apart, parts)},
                              {"confirmed", e.confirmed},
                              {"denied", e.contradicted},
                              {"parameters", parameters}});
  }
  out["own"] = c.own;
  out["by_others"] = json::array();
  for (const Validation& v : c.by_others) {
    out["by_others"].push_back(share_json(v.share, v.ci95));
    out["by_others"].back().update({{"file", v.file}, {"sensor", v.sensor}});
  }
  return out.dump(2, ' ', false, json::error_handler_t::replace) + "\n";
}

}  // namespace stillpoint::diag
