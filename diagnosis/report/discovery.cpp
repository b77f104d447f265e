#include "diagnosis/report/discovery.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "diagnosis/discovery/law_words.h"
#include "report/document.h"

namespace stillpoint::diag {
namespace {

using report::escaped;

constexpr std::size_t kMostWeighed = 10, kFewestDrawn = 3;

/// Why a law that was weighed is not the one that is stated.
std::string why_not(const WeighedLaw& law, const WeighedLaw& stated) {
  if (law.text == stated.text) return "<b>stated</b>";
  const char* length = law.bits < stated.bits ? "shorter" : law.bits > stated.bits ? "longer" : "as long";
  const double less = stated.gain_nats - law.gain_nats;
  if (less > 0.0) return fmt::format("{}; explains {:.0f} nats less", length, less);
  return fmt::format("{}; explains {:.0f} nats more, {}", length, -less,
                     law.net_nats > stated.net_nats ? "by more numbers, or by such as are open or fail elsewhere"
                                                    : "which do not pay for it");
}

std::string weighed_table(const Finding& f, const std::string& stated_text, std::size_t k) {
  const auto stated = std::find_if(f.weighed.begin(), f.weighed.end(),
                                   [&stated_text](const WeighedLaw& w) { return w.text == stated_text; });
  if (stated == f.weighed.end()) return {};
  std::string s =
      "<h3>What was weighed against it</h3><p class=\"how\">A longer text and more coefficients have to pay for "
      "themselves. Gain: log-likelihood over the model without the law.</p><table><tr><th>law</th><th "
      "class=\"n\">length, bits</th><th class=\"n\">gain, nats</th><th class=\"n\">after its price</th><th></th></tr>";
  for (std::size_t i = 0; i < f.weighed.size(); ++i) {
    const WeighedLaw& w = f.weighed[i];
    if (i >= kMostWeighed && w.text != stated_text) continue;
    s += fmt::format(
        "<tr><td><code>{}</code></td><td class=\"n\">{:.0f}</td><td class=\"n\">{:.0f}</td><td "
        "class=\"n\">{:.0f}</td><td>{}</td></tr>",
        escaped(w.text), w.bits, w.gain_nats, w.net_nats, why_not(w, *stated));
  }
  s += "</table>";
  if (f.weighed.size() >= kFewestDrawn)
    s += "<div class=\"figures\">" +
         report::figure_html(fmt::format("weighed-{}", k), "Gain over length",
                             "Each point is a law that was weighed; blue is the stated one. Further up explains more, "
                             "further left is simpler.") +
         "</div>";
  return s;
}

}  // namespace

std::vector<report::Plot> discovery_plots(const Finding& f, std::size_t k) {
  const auto law = law_json(f);
  if (!law || f.weighed.size() < kFewestDrawn) return {};
  report::Plot p{fmt::format("weighed-{}", k), "length, bits", "gain, nats", {}, {}};
  report::Curve others{"weighed", report::Colour::kBefore, {}, report::Mark::kDots},
      stated{"stated", report::Colour::kAccent, {}, report::Mark::kDots};
  for (const WeighedLaw& w : f.weighed) {
    const bool is_stated = w.text == law->at("text").get<std::string>();
    p.x.push_back(w.bits);
    others.y.push_back(is_stated ? std::nan("") : w.gain_nats);
    stated.y.push_back(is_stated ? w.gain_nats : std::nan(""));
  }
  p.curves = {others, stated};
  return {report::in_order_of_x(std::move(p))};
}

std::string discovery_html(const Finding& f, std::size_t k) {
  const auto law = law_json(f);
  if (!law) return {};
  std::string s;
  if (const auto& known = law->at("mechanisms"); !known.empty()) {
    s += "<h3>Sensors are known to behave so by</h3><ul>";
    for (const auto& words : known) s += "<li>" + escaped(words.get<std::string>()) + "</li>";
    s += "</ul>";
  }
  s += weighed_table(f, law->at("text").get<std::string>(), k);
  if (f.figures.against_each.empty()) return s;
  s += "<h3>Residual against each quantity</h3><p class=\"how\">Orange before, green after: where the law is right, "
       "green is one even band in every panel. A slope or a bend that is left names what is still missing.</p><div "
       "class=\"figures\">";
  for (std::size_t i = 0; i < f.figures.against_each.size(); ++i)
    s += fmt::format("<div class=\"plot\" id=\"each-{}-{}\"></div>", k, i);
  return s + "</div>";
}

}  // namespace stillpoint::diag
