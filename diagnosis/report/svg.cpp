#include "diagnosis/report/svg.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "diagnosis/finding_effect.h"
#include "report/document.h"

namespace stillpoint::diag::svg {
namespace {

using report::escaped;

constexpr double kWidth = 900.0;
constexpr std::size_t kMostColumns = 120;
constexpr std::size_t kMostRanked = 14;
constexpr double kPlain_nats = 100.0;  // the full colour at least: noise must not glow for want of anything else

/// Compresses gains, which span decades, so that small ones stay visible.
double soft(double nats) { return nats <= 0 ? 0.0 : std::log10(1.0 + nats); }

}  // namespace

std::string heat_map(const Diagnosis& d) {
  const std::size_t rows = std::min(d.heat_channels.size(), d.heat_nats.size());
  if (rows == 0 || d.heat_t_s.empty()) return {};
  const std::size_t step = (d.heat_t_s.size() + kMostColumns - 1) / kMostColumns;
  const std::size_t columns = (d.heat_t_s.size() + step - 1) / step;
  double largest = kPlain_nats;
  std::vector<std::vector<double>> cell(rows, std::vector<double>(columns, 0.0));
  for (std::size_t r = 0; r < rows; ++r)
    for (std::size_t c = 0; c < std::min(d.heat_nats[r].size(), d.heat_t_s.size()); ++c) {
      auto& x = cell[r][c / step];
      x = std::max(x, d.heat_nats[r][c]);
      largest = std::max(largest, x);
    }
  const double left = 60, height = 20, width = (kWidth - left) / static_cast<double>(columns);
  const double bottom = height * static_cast<double>(rows);
  std::string s = fmt::format("<svg viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"misfit per channel and time\">",
                              kWidth, bottom + 46);
  for (std::size_t r = 0; r < rows; ++r) {
    const double y = height * static_cast<double>(r);
    s += fmt::format("<text x=\"0\" y=\"{}\">{}</text>", y + 14, escaped(d.heat_channels[r]));
    for (std::size_t c = 0; c < columns; ++c)
      s += fmt::format(
          "<rect x=\"{:.1f}\" y=\"{}\" width=\"{:.2f}\" height=\"{}\" fill=\"var(--before)\" fill-opacity=\"{:.2f}\">"
          "<title>{} {:.1f} s: {:.1f} nats</title></rect>",
          left + width * static_cast<double>(c), y + 1, width, height - 2,
          0.04 + 0.96 * soft(cell[r][c]) / soft(largest), escaped(d.heat_channels[r]), d.heat_t_s[c * step],
          cell[r][c]);
  }
  for (int k = 0; k <= 6; ++k) {
    const auto at = std::min(d.heat_t_s.size() - 1, d.heat_t_s.size() * static_cast<std::size_t>(k) / 6);
    s += fmt::format("<text class=\"quiet\" x=\"{:.0f}\" y=\"{}\" text-anchor=\"{}\">{:.0f} s</text>",
                     left + (kWidth - left) * k / 6.0, bottom + 16,
                     k == 0   ? "start"
                     : k == 6 ? "end"
                              : "middle",
                     d.heat_t_s[at]);
  }
  s += fmt::format(
      "<text class=\"quiet\" x=\"{}\" y=\"{}\">faint: agrees within noise; full colour: {:.3g} nats in one "
      "block</text></svg>",
      left, bottom + 38, largest);
  return s;
}

std::string ranking(const Diagnosis& d) {
  auto ranked = d.ranking;
  std::sort(ranked.begin(), ranked.end(), [](const auto& a, const auto& b) { return a.gain_nats > b.gain_nats; });
  std::vector<std::string> seen;  // a sensor is searched in several rounds; the best gain of a name counts
  std::erase_if(ranked, [&seen](const RankedHypothesis& h) {
    if (std::find(seen.begin(), seen.end(), h.effect) != seen.end()) return true;
    seen.push_back(h.effect);
    return false;
  });
  if (ranked.size() > kMostRanked) ranked.resize(kMostRanked);
  if (ranked.empty()) return {};
  const double left = 190, right = 90, height = 19;
  const double full = soft(std::max({ranked.front().gain_nats, d.abstention_nats, 1.0}));
  const auto x = [&](double nats) { return left + (kWidth - left - right) * soft(nats) / full; };
  const double bottom = height * static_cast<double>(ranked.size());
  std::string s = fmt::format("<svg viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"ranking of the hypotheses\">",
                              kWidth, bottom + 26);
  for (std::size_t i = 0; i < ranked.size(); ++i) {
    const double y = height * static_cast<double>(i);
    const bool stated = contains(d.findings, ranked[i].effect);
    s += fmt::format("<text x=\"{}\" y=\"{}\" text-anchor=\"end\">{}</text>", left - 8, y + 14,
                     escaped(ranked[i].effect));
    s += fmt::format("<rect x=\"{}\" y=\"{}\" width=\"{:.1f}\" height=\"{}\" rx=\"2\" fill=\"var({})\"/>", left, y + 3,
                     std::max(1.0, x(ranked[i].gain_nats) - left), height - 6, stated ? "--accent" : "--noise");
    s += fmt::format("<text class=\"quiet\" x=\"{:.1f}\" y=\"{}\">{:.1f}</text>", x(ranked[i].gain_nats) + 6, y + 14,
                     ranked[i].gain_nats);
  }
  s += fmt::format(
      "<line x1=\"{0:.1f}\" x2=\"{0:.1f}\" y1=\"0\" y2=\"{1}\" stroke=\"var(--bad)\" stroke-dasharray=\"4 3\"/>"
      "<text class=\"quiet\" x=\"{0:.1f}\" y=\"{2}\" text-anchor=\"{4}\">no name below {3:.1f} nats</text></svg>",
      x(d.abstention_nats), bottom, bottom + 16, d.abstention_nats,
      x(d.abstention_nats) > kWidth / 2 ? "end" : "start");
  return s;
}

std::string parameter_range(const Parameter& p, double typical_low, double typical_high) {
  const double size = std::abs(p.value);
  if (!(typical_low > 0) || !(typical_high > typical_low) || !(size > 0)) return {};
  const double low = std::log10(typical_low) - 2.0, high = std::log10(typical_high) + 2.0, width = 170.0;
  const auto x = [&](double v) {
    return width * std::clamp((std::log10(std::max(v, 1e-300)) - low) / (high - low), 0.0, 1.0);
  };
  const bool straddles = p.ci95[0] < 0 && p.ci95[1] > 0;
  const double a = straddles ? 0.0 : std::min(std::abs(p.ci95[0]), std::abs(p.ci95[1]));
  const double b = std::max(std::abs(p.ci95[0]), std::abs(p.ci95[1]));
  return fmt::format(
      "<svg viewBox=\"0 0 {0} 16\" width=\"{0}\" height=\"16\"><line class=\"line\" x1=\"0\" x2=\"{0}\" y1=\"8\" "
      "y2=\"8\"/>"
      "<rect x=\"{1:.1f}\" y=\"3\" width=\"{2:.1f}\" height=\"10\" fill=\"var(--noise)\" "
      "fill-opacity=\"0.45\"><title>usual {3:.3g} to "
      "{4:.3g}</title></rect><line x1=\"{5:.1f}\" x2=\"{6:.1f}\" y1=\"8\" y2=\"8\" stroke=\"var(--accent)\" "
      "stroke-width=\"3\"/>"
      "<circle cx=\"{7:.1f}\" cy=\"8\" r=\"3.4\" fill=\"var(--accent)\"/></svg>",
      width, x(typical_low), x(typical_high) - x(typical_low), typical_low, typical_high, x(a), x(b), x(size));
}

}  // namespace stillpoint::diag::svg
