#include "diagnosis/report/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "diagnosis/report/discovery.h"
#include "diagnosis/report/finding_plots.h"
#include "diagnosis/report/svg.h"
#include "diagnosis/summary.h"
#include "report/document.h"
#include "simulation/effect_catalogue.h"

namespace stillpoint::diag {

namespace {

using report::escaped;

const char* verdict_words(Verdict v) {
  switch (v) {
    case Verdict::kNoMismatch:
      return "No mismatch";
    case Verdict::kWrongNumbers:
      return "Wrong numbers in the simulation";
    case Verdict::kSurplusPhysics:
      return "Physics in the simulation that the recording has not";
    case Verdict::kExplained:
      return "Mismatch found and explained";
    case Verdict::kPartlyExplained:
      return "Mismatch found, explained in part";
    case Verdict::kUnexplained:
      return "Mismatch found, not explained";
    case Verdict::kInsufficientData:
      return "Insufficient data";
  }
  return "";
}

std::string joined(const std::vector<std::string>& words) {
  std::string all;
  for (const auto& w : words) all += (all.empty() ? "" : ", ") + w;
  return escaped(all);
}

/// The catalogue's parameter of this finding's: by symbol ("k" of "k_x"), or the only one.
const sim::EffectParameter* catalogued(const std::string& effect, const std::string& parameter) {
  const auto* info = sim::find_effect(effect);
  if (info == nullptr) return nullptr;
  for (const auto& p : info->parameters)
    if (p.symbol == parameter.substr(0, parameter.find('_'))) return &p;
  return info->parameters.size() == 1 ? &info->parameters.front() : nullptr;
}

std::string parameter_table(const Finding& f) {
  if (f.parameters.empty()) return {};
  const bool is_usual = std::any_of(f.parameters.begin(), f.parameters.end(),
                                    [&f](const Parameter& p) { return catalogued(f.effect, p.name) != nullptr; });
  std::string s = "<h3>Parameters</h3>";
  if (is_usual)
    s += "<p class=\"how\">Blue is the value with its 95 % interval, grey the range usual for such sensors "
         "(logarithmic in size); far outside it, the driver may stand in for another.</p>";
  s += fmt::format(
      "<table><tr><th>name</th><th class=\"n\">value</th><th class=\"n\">95 % interval</th><th>unit</th>{}</tr>",
      is_usual ? "<th>against the usual</th>" : "");
  for (const auto& p : f.parameters) {
    const auto* usual = catalogued(f.effect, p.name);
    s += fmt::format(
        "<tr><td><code>{}</code></td><td class=\"n\">{:.5g}</td><td class=\"n\">{:.5g} … "
        "{:.5g}</td><td>{}</td>{}</tr>",
        escaped(p.name), p.value, p.ci95[0], p.ci95[1], escaped(p.unit),
        usual ? "<td>" + svg::parameter_range(p, usual->typical_low, usual->typical_high) + "</td>" : "");
  }
  return s + "</table>";
}

std::string held_out_line(const HeldOut& h) {
  if (h.blocks == 0)
    return "<h3>Evidence</h3><p>Shows without a fit, in the readings or their means; it has no course that could be "
           "predicted on other data.</p>";
  return fmt::format(
      "<h3>On data not used for the fit</h3><p>Gain {} nats; {} of {} blocks better; {:.0f} % of the removable "
      "error removed; rms {:.4g} before, {:.4g} after, {:.4g} noise floor ({}).</p><p class=\"how\">Under a noisy "
      "reference the rms hardly moves; the gain in nats is what counts: above 5 it is beyond chance.</p>",
      h.gain_nats < 1e4 ? fmt::format("{:.1f}", h.gain_nats) : fmt::format("{:.3g}", h.gain_nats), h.blocks_better,
      h.blocks, 100.0 * h.removable_share_removed, h.rms_before, h.rms_after, h.noise_floor, escaped(h.unit));
}

std::string confidence_words(const Finding& f) {
  const std::string p = !f.p_value           ? "no p-value computed"
                        : *f.p_value < 1e-40 ? "p &lt; 1e-40"
                                             : fmt::format("p = {:.1e}", *f.p_value);
  return f.confidence ? fmt::format("{:.2g}; {}", *f.confidence, p) : p;
}

std::string further_terms(const WiderLaw& w) {
  std::string s = "of <code>" + escaped(w.effect) + "</code>, which has more terms:";
  for (const Parameter& p : w.further)
    s += fmt::format(" <code>{}</code> {:.2g} … {:.2g} {};", escaped(p.name), p.ci95[0], p.ci95[1], escaped(p.unit));
  s.back() = '.';
  return s;
}

std::string finding_card(const Finding& f, std::size_t k) {
  const auto* info = sim::find_effect(f.effect);
  std::string s = fmt::format("<section class=\"card\"><h2>{}. {} <code>{}</code></h2>", k + 1,
                              info ? escaped(info->title) : "Outside the catalogue", escaped(f.effect));
  s += "<table>";
  const auto row = [&s](const std::string& what, const std::string& html) {
    if (!html.empty()) s += fmt::format("<tr><th>{}</th><td>{}</td></tr>", what, html);
  };
  row("where", joined(f.channels));
  row("when", fmt::format("{:.2f} to {:.2f} s; {}", f.interval_s[0], f.interval_s[1], escaped(f.regime)));
  row("law", f.equation.empty() ? "" : "<code>" + escaped(f.equation) + "</code>");
  row("driver", escaped(f.driver));
  row("confidence", confidence_words(f));
  if (const auto others = not_excluded(f); !others.empty()) row("cannot be told from", joined(others));
  if (f.wider) row("bounds", further_terms(*f.wider));
  if (!f.runner_up_effect.empty()) row("runner-up", escaped(f.runner_up_effect + ": " + f.runner_up_why_rejected));
  row("would decide", escaped(f.decided_by));
  return s + "</table>" + parameter_table(f) + held_out_line(f.held_out) + figures_html(f.figures, k) +
         discovery_html(f, k) + "</section>";
}

std::string baseline_tables(const Diagnosis& d) {
  std::string s;
  if (!d.configuration.empty()) {
    s += "<h2>Wrong numbers, not missing physics</h2><ul>";
    for (const auto& c : d.configuration)
      s += fmt::format("<li><b>{}</b>: {}</li>", escaped(c.sensor), escaped(c.what));
    s += "</ul>";
  }
  if (!d.noise.empty()) {
    s += "<h2>Noise</h2><table><tr><th>channel</th><th class=\"n\">configured</th><th class=\"n\">measured</th></tr>";
    for (const auto& n : d.noise)
      s += fmt::format("<tr><td>{}</td><td class=\"n\">{:.4g}</td><td class=\"n\">{:.4g}</td></tr>", escaped(n.channel),
                       n.configured, n.measured);
    s += "</table>";
  }
  if (!d.residual.empty()) {
    s += "<h2>Every channel</h2><p class=\"how\">The last column is the smallest effect that would have been seen: "
         "where nothing was found, nothing "
         "larger hides.</p><table><tr><th>channel</th><th class=\"n\">rms before</th><th class=\"n\">rms "
         "after</th><th>only noise left</th>"
         "<th class=\"n\">smallest seen</th><th>unit</th></tr>";
    for (const auto& r : d.residual)
      s += fmt::format(
          "<tr><td>{}</td><td class=\"n\">{:.4g}</td><td class=\"n\">{:.4g}</td><td>{}</td><td "
          "class=\"n\">{:.3g}</td><td>{}</td></tr>",
          escaped(r.channel), r.rms_before, r.rms_after, r.white ? "yes" : "no", r.smallest_seen, escaped(r.unit));
    s += "</table>";
  }
  return s;
}

std::string next_steps(const Diagnosis& d, const ReportContext& context) {
  std::string s = "<h2>Next</h2>";
  if (!context.blocks_to_paste.empty())
    s += "<p>Put the physics into the simulation, then run <code>stillpoint diagnose</code> again: it must find no "
         "mismatch.</p><pre><code>" +
         escaped(context.blocks_to_paste) + "</code></pre>";
  for (const CodeBlock& c : context.code)
    s += fmt::format("<details><summary>{}</summary><pre><code>{}</code></pre></details>", escaped(c.title),
                     escaped(c.text));
  std::string items;
  for (const auto& f : d.findings)
    if (!f.decided_by.empty())
      items += fmt::format("<li><code>{}</code>: {}</li>", escaped(f.effect), escaped(f.decided_by));
  for (const auto& n : d.notices) items += "<li>" + escaped(n) + "</li>";
  if (items.empty()) items = "<li>Nothing to do: the simulation explains this recording.</li>";
  return s + "<ul>" + items + "</ul>";
}

}  // namespace

std::string report_html(const Diagnosis& d, const ReportContext& context) {
  std::string s = fmt::format(
      "<div class=\"verdict {}\"><div class=\"label\">{}</div><h1>{}</h1><p class=\"small\">Recording {} against "
      "simulation {}{}</p></div>",
      verdict_word(d.verdict), verdict_words(d.verdict), escaped(d.summary), escaped(context.recording),
      escaped(context.simulation), context.validation.empty() ? "" : "; checked on " + escaped(context.validation));
  std::vector<report::Plot> plots;
  for (std::size_t k = 0; k < d.findings.size(); ++k) {
    s += finding_card(d.findings[k], k);
    for (auto& plot : finding_plots(d.findings[k].figures, k)) plots.push_back(std::move(plot));
    for (auto& plot : discovery_plots(d.findings[k], k)) plots.push_back(std::move(plot));
  }
  if (const auto map = svg::heat_map(d); !map.empty())
    s += "<h2>Where and when</h2><p class=\"how\">Misfit of the given simulation per channel and block of time, before "
         "anything was added: cells in full "
         "colour are where recording and simulation part.</p><div class=\"wide\">" +
         map + "</div>";
  if (const auto bars = svg::ranking(d); !bars.empty())
    s += "<h2>Hypotheses</h2><p class=\"how\">Gain of each single law over the simulation, after the charge for its "
         "parameters; left of the red line "
         "no name is stated. Blue: stated above.</p><div class=\"wide\">" +
         bars + "</div>";
  s += baseline_tables(d) + next_steps(d, context);
  return report::document_html("Diagnosis of " + context.recording, s, plots);
}

}  // namespace stillpoint::diag
