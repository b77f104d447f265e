#include "diagnosis/summary.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "diagnosis/answer_words.h"
#include "diagnosis/discovery/law_words.h"
#include "simulation/effect_catalogue.h"

namespace stillpoint::diag {
namespace {

using nlohmann::json;

std::string title(const std::string& id) {
  const sim::EffectInfo* info = sim::find_effect(id);
  return info == nullptr ? id : info->title;
}

json finding_json(const Finding& f) {
  json parameters = json::array();
  for (const auto& p : f.parameters) parameters.push_back(parameter_json(p));
  json out{{"effect", f.effect},
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
           {"runner_up", {{"effect", f.runner_up_effect}, {"why_rejected", f.runner_up_why_rejected}}},
           {"decided_by", f.decided_by}};
  if (f.wider) {
    out["wider"] = {{"effect", f.wider->effect}, {"further", json::array()}};
    for (const auto& p : f.wider->further) out["wider"]["further"].push_back(parameter_json(p));
  }
  if (const auto law = law_json(f)) out["law"] = *law;
  if (f.p_value) out["p_value"] = number(*f.p_value);
  if (f.confidence) out["confidence"] = number(*f.confidence);
  if (f.held_out.on.empty()) return out;
  out["removed_held_out"] = share_json(f.held_out.removable_share_removed, f.held_out.share_ci95);
  out["removed_held_out"]["on"] = f.held_out.on;
  return out;
}

/// What the findings of one sensor or of the whole simulation remove elsewhere; "gyr: 0.98 (0.97 to 0.99)".
std::string validation_text(const Validation& v) {
  if (!std::isfinite(v.share))
    return fmt::format("{}: nothing there to remove, the motion does not excite it\n", v.sensor);
  return fmt::format("{}: {:.3g} of the removable residual is gone ({:.3g} to {:.3g}); rms {:.4g} -> {:.4g} {}\n",
                     v.sensor, v.share, v.ci95[0], v.ci95[1], v.rms_before, v.rms_after, v.unit);
}

std::string finding_text(const Finding& f) {
  std::string out =
      fmt::format("WHERE    {}\nWHEN     {} ({:.1f} to {:.1f} s)\nPHYSICS  {}    {}\n", fmt::join(f.channels, ", "),
                  f.regime, f.interval_s[0], f.interval_s[1], f.equation, f.effect);
  for (const auto& p : f.parameters) out += parameter_text(p) + "\n";
  const std::string p =
      f.p_value ? fmt::format(", p = {:.2g} after correcting for all hypotheses", *f.p_value) : std::string();
  if (f.held_out.blocks == 0)
    out += fmt::format("EVIDENCE shows without a fit, in the readings or their means{}\n", p);
  else
    out += fmt::format("EVIDENCE held-out gain {:.0f} nats ({} of {} blocks better){}; rms {:.4g} -> {:.4g} {}\n",
                       f.held_out.gain_nats, f.held_out.blocks_better, f.held_out.blocks, p, f.held_out.rms_before,
                       f.held_out.rms_after, f.held_out.unit);
  if (!f.held_out.on.empty())
    out += fmt::format("REMOVES  {:.3g} ({:.3g} to {:.3g}) of the removable residual on {} left out of the fit\n",
                       f.held_out.removable_share_removed, f.held_out.share_ci95[0], f.held_out.share_ci95[1],
                       f.held_out.on);
  if (!f.runner_up_effect.empty())
    out += fmt::format("RUNNER-UP {}: {}\n", f.runner_up_effect, f.runner_up_why_rejected);
  if (const auto others = not_excluded(f); !others.empty())
    out += fmt::format("NOT EXCLUDED {}\n", fmt::join(others, ", "));
  if (f.wider) out += fmt::format("BOUNDS   terms that {} has beside these\n", f.wider->effect);
  if (f.wider)
    for (const auto& term : f.wider->further) out += parameter_text(term) + "\n";
  return out + "NEXT     " + f.decided_by + "\n";
}

/// Wrong noise of the simulation, and what is left, whatever else is missing: " The noise is not ..."; empty where
/// there is neither.
std::string noise_told(const Diagnosis& d) {
  std::vector<std::string> parts;
  for (const auto& n : d.noise) parts.push_back(fmt::format("{} {:.1f} times", n.channel, n.measured / n.configured));
  std::string out = parts.empty() ? "" : fmt::format(" The noise is not as configured: {}.", fmt::join(parts, ", "));
  if (!d.unaccounted.empty()) out += fmt::format(" Left without a cause: {}.", fmt::join(d.unaccounted, "; "));
  return out;
}

}  // namespace

const char* verdict_word(Verdict verdict) {
  switch (verdict) {
    case Verdict::kNoMismatch:
      return "no_mismatch";
    case Verdict::kWrongNumbers:
      return "wrong_numbers";
    case Verdict::kSurplusPhysics:
      return "surplus_physics";
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

std::string summarise(const Diagnosis& d) {
  const std::string noise = noise_told(d);
  if (d.findings.empty() && !d.surplus.empty())
    return fmt::format("The simulation has physics that the recording has not: {}.", d.surplus.front().effect) + noise;
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
    for (const auto& e : not_excluded(f)) name += " or " + e;
    parts.push_back(name + (f.channels.empty() ? "" : fmt::format(" in {}", fmt::join(f.channels, ", "))));
  }
  return fmt::format("Missing physics: {}.", fmt::join(parts, "; ")) + noise;
}

namespace {

/// The smallest offset that this motion would show; on a still bench the matrix takes the place of every offset.
std::string offset_seen(const ChannelResidual& r) {
  constexpr double kHidden = 10.0;  // times the remaining deviation
  if (!(r.smallest_seen < kHidden * r.rms_after)) return "this motion does not tell an offset from the matrix";
  return fmt::format("an offset is seen from {:.2g} on", r.smallest_seen);
}

}  // namespace

std::string to_text(const Diagnosis& d) {
  std::string out = fmt::format("VERDICT  {}  [{}]\n", d.summary, verdict_word(d.verdict));
  for (const Finding& f : d.findings) out += "\n" + finding_text(f);
  out += "\n";
  for (const auto& c : d.configuration) out += fmt::format("BASELINE {}: {}\n", c.sensor, c.what);
  for (const auto& x : d.surplus)
    out += fmt::format("SURPLUS  {}: {:.3g} of its configured size is in the recording ({:.3g} to {:.3g})\n", x.effect,
                       x.in_recording, x.ci95[0], x.ci95[1]);
  for (const auto& v : d.validation) out += fmt::format("VALIDATE {} {}", v.file, validation_text(v));
  for (const auto& n : d.noise)
    out += fmt::format("NOISE    {}: configured {:.3g}, measured {:.3g}\n", n.channel, n.configured, n.measured);
  for (const auto& r : d.residual)
    out += fmt::format("CHANNEL  {}: rms {:.4g} -> {:.4g} {}, {}; {}\n", r.channel, r.rms_before, r.rms_after, r.unit,
                       r.white ? "white" : "not white", offset_seen(r));
  for (const auto& n : d.notices) out += "NOTICE   " + n + "\n";
  return wrapped(out);
}

std::string to_json(const Diagnosis& d) {
  json out{{"schema", "stillpoint.diagnosis/1"}, {"verdict", verdict_word(d.verdict)}, {"summary", d.summary}};
  out["findings"] = json::array();
  for (const auto& f : d.findings) out["findings"].push_back(finding_json(f));
  out["configuration"] = json::array();
  for (const auto& c : d.configuration) {
    json values = json::array();
    for (const auto& p : c.values) values.push_back(parameter_json(p));
    out["configuration"].push_back({{"sensor", c.sensor}, {"what", c.what}, {"values", values}});
  }
  out["surplus"] = json::array();
  for (const auto& x : d.surplus)
    out["surplus"].push_back({{"effect", x.effect},
                              {"in_simulation", number(x.in_simulation)},
                              {"in_recording", number(x.in_recording)},
                              {"ci95", {number(x.ci95[0]), number(x.ci95[1])}}});
  out["validation"] = json::array();
  for (const auto& v : d.validation) {
    out["validation"].push_back(share_json(v.share, v.ci95));
    out["validation"].back().update({{"file", v.file},
                                     {"sensor", v.sensor},
                                     {"rms_before", number(v.rms_before)},
                                     {"rms_after", number(v.rms_after)},
                                     {"unit", v.unit}});
  }
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
