#include "diagnosis/summary.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "simulation/effect_catalogue.h"

namespace stillpoint::diag {
namespace {

using nlohmann::json;

std::string title(const std::string& id) {
  const sim::EffectInfo* info = sim::find_effect(id);
  return info == nullptr ? id : info->title;
}

bool is_unknown(const Finding& f) { return f.effect.rfind("unknown", 0) == 0; }

/// JSON has no infinity or NaN.
json number(double x) { return std::isfinite(x) ? json(x) : json(nullptr); }

json finding_json(const Finding& f) {
  json parameters = json::array();
  for (const auto& p : f.parameters)
    parameters.push_back({{"name", p.name},
                          {"value", number(p.value)},
                          {"ci95", {number(p.ci95[0]), number(p.ci95[1])}},
                          {"unit", p.unit}});
  return {{"effect", f.effect},
          {"equivalent", f.equivalent},
          {"channels", f.channels},
          {"interval_s", f.interval_s},
          {"regime", f.regime},
          {"equation", f.equation},
          {"driver", f.driver},
          {"parameters", parameters},
          {"held_out",
           {{"rms_before", number(f.held_out.rms_before)},
            {"rms_after", number(f.held_out.rms_after)},
            {"noise_floor", number(f.held_out.noise_floor)},
            {"unit", f.held_out.unit},
            {"gain_nats", number(f.held_out.gain_nats)},
            {"removable_share_removed", number(f.held_out.removable_share_removed)},
            {"blocks_better", f.held_out.blocks_better},
            {"blocks", f.held_out.blocks}}},
          {"p_value", number(f.p_value)},
          {"confidence", number(f.confidence)},
          {"runner_up", {{"effect", f.runner_up_effect}, {"why_rejected", f.runner_up_why_rejected}}},
          {"decided_by", f.decided_by}};
}

std::string finding_text(const Finding& f) {
  std::string out =
      fmt::format("WHERE    {}\nWHEN     {} ({:.1f} to {:.1f} s)\nPHYSICS  {}    {}\n", fmt::join(f.channels, ", "),
                  f.regime, f.interval_s[0], f.interval_s[1], f.equation, f.effect);
  for (const auto& p : f.parameters)
    out += fmt::format("         {} = {:+.4g} +- {:.2g} {}\n", p.name, p.value, 0.5 * (p.ci95[1] - p.ci95[0]), p.unit);
  if (f.held_out.blocks == 0)
    out += fmt::format("EVIDENCE shows without a fit, in the readings or their means; p = {:.2g}\n", f.p_value);
  else
    out += fmt::format(
        "EVIDENCE held-out gain {:.0f} nats ({} of {} blocks better), p = {:.2g} after correcting for all hypotheses; "
        "rms {:.4g} -> {:.4g} {}\n",
        f.held_out.gain_nats, f.held_out.blocks_better, f.held_out.blocks, f.p_value, f.held_out.rms_before,
        f.held_out.rms_after, f.held_out.unit);
  if (!f.runner_up_effect.empty())
    out += fmt::format("RUNNER-UP {}: {}\n", f.runner_up_effect, f.runner_up_why_rejected);
  if (!f.equivalent.empty()) out += fmt::format("NOT EXCLUDED {}\n", fmt::join(f.equivalent, ", "));
  return out + "NEXT     " + f.decided_by + "\n";
}

/// Lines that fit a terminal of 80 columns, what follows set in under the text of the first.
std::string wrapped(const std::string& text) {
  constexpr std::size_t kColumns = 80, kIndent = 9;
  std::string out;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line); out += line + "\n") {
    while (line.size() > kColumns) {
      const std::size_t space = line.rfind(' ', kColumns);
      const std::size_t cut = space == std::string::npos || space <= kIndent ? line.find(' ', kColumns) : space;
      if (cut == std::string::npos) break;  // one long word
      out += line.substr(0, line.find_last_not_of(' ', cut) + 1) + "\n";
      line = std::string(kIndent, ' ') + line.substr(cut + 1);
    }
  }
  return out;
}

/// A wrong number of the simulation too, whatever else is missing: " The noise is not ..."; empty where it is right.
std::string noise_told(const Diagnosis& d) {
  std::vector<std::string> parts;
  for (const auto& n : d.noise) parts.push_back(fmt::format("{} {:.1f} times", n.channel, n.measured / n.configured));
  return parts.empty() ? "" : fmt::format(" The noise is not as configured: {}.", fmt::join(parts, ", "));
}

}  // namespace

const char* verdict_word(Verdict verdict) {
  switch (verdict) {
    case Verdict::kNoMismatch:
      return "no_mismatch";
    case Verdict::kExplained:
      return "explained";
    case Verdict::kPartlyExplained:
      return "partly_explained";
    case Verdict::kUnexplained:
      return "unexplained";
    case Verdict::kInsufficientData:
      break;
  }
  return "insufficient_data";
}

std::string summarise(const Diagnosis& d) {
  const std::string noise = noise_told(d);
  if (d.findings.empty() && d.configuration.empty())
    return noise.empty() ? "No mismatch. The simulation explains the recording within its noise."
                         : "No missing physics." + noise;
  if (d.findings.empty())
    return "Wrong numbers, not missing physics: " + d.configuration.front().sensor + " " +
           d.configuration.front().what + "." + noise;
  std::vector<std::string> parts;
  for (const Finding& f : d.findings) {
    std::string name = is_unknown(f) ? "an effect outside the catalogue driven by " + f.driver
                                     : title(f.effect) + " (" + f.effect + ")";
    for (const auto& e : f.equivalent) name += " or " + e;
    parts.push_back(name + (f.channels.empty() ? "" : fmt::format(" in {}", fmt::join(f.channels, ", "))));
  }
  return fmt::format("Missing physics: {}.", fmt::join(parts, "; ")) + noise;
}

std::string to_text(const Diagnosis& d) {
  std::string out = fmt::format("VERDICT  {}  [{}]\n", d.summary, verdict_word(d.verdict));
  for (const Finding& f : d.findings) out += "\n" + finding_text(f);
  out += "\n";
  for (const auto& c : d.configuration) out += fmt::format("BASELINE {}: {}\n", c.sensor, c.what);
  for (const auto& n : d.noise)
    out += fmt::format("NOISE    {}: configured {:.3g}, measured {:.3g}\n", n.channel, n.configured, n.measured);
  for (const auto& r : d.residual)
    out += fmt::format("CHANNEL  {}: rms {:.4g} -> {:.4g} {}, {}; an offset is seen from {:.2g} on\n", r.channel,
                       r.rms_before, r.rms_after, r.unit, r.white ? "white" : "not white", r.smallest_seen);
  for (const auto& n : d.notices) out += "NOTICE   " + n + "\n";
  return wrapped(out);
}

std::string to_json(const Diagnosis& d) {
  json out{{"schema", "stillpoint.diagnosis/1"}, {"verdict", verdict_word(d.verdict)}, {"summary", d.summary}};
  out["findings"] = json::array();
  for (const auto& f : d.findings) out["findings"].push_back(finding_json(f));
  out["configuration"] = json::array();
  for (const auto& c : d.configuration) out["configuration"].push_back({{"sensor", c.sensor}, {"what", c.what}});
  out["noise"] = json::array();
  for (const auto& n : d.noise)
    out["noise"].push_back({{"channel", n.channel}, {"configured", n.configured}, {"measured", n.measured}});
  out["residual"] = json::array();
  for (const auto& r : d.residual)
    out["residual"].push_back({{"channel", r.channel},
                               {"rms_before", number(r.rms_before)},
                               {"rms_after", number(r.rms_after)},
                               {"white", r.white},
                               {"smallest_seen", number(r.smallest_seen)},
                               {"unit", r.unit}});
  out["notices"] = d.notices;
  return out.dump(2, ' ', false, json::error_handler_t::replace) + "\n";
}

}  // namespace stillpoint::diag
