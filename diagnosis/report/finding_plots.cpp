#include "diagnosis/report/finding_plots.h"

#include <fmt/format.h>

#include <numeric>

#include "report/document.h"

namespace stillpoint::diag {
namespace {

using report::Colour;
using report::Mark;
using report::Plot;

Plot spectrum(const FindingFigures& f, const std::string& id) {
  Plot p{id,
         "frequency, Hz",
         "power, (" + f.unit + ")²/Hz",
         f.frequency_hz,
         {{"before", Colour::kBefore, f.psd_before},
          {"after", Colour::kAfter, f.psd_after},
          {"noise", Colour::kNoise, f.psd_noise, Mark::kDashed}}};
  p.log_x = !f.frequency_hz.empty() && f.frequency_hz.front() > 0.0;
  p.log_y = true;
  return p;
}

Plot autocorrelation(const FindingFigures& f, const std::string& id) {
  std::vector<double> lags(f.autocorrelation_before.size());
  std::iota(lags.begin(), lags.end(), 0.0);
  const std::vector<double> upper(lags.size(), f.autocorrelation_band), lower(lags.size(), -f.autocorrelation_band);
  return {id,
          "lag, samples",
          "autocorrelation",
          lags,
          {{"before", Colour::kBefore, f.autocorrelation_before},
           {"after", Colour::kAfter, f.autocorrelation_after},
           {"white noise, 95 %: from", Colour::kNoise, lower, Mark::kDashed},
           {"to", Colour::kNoise, upper, Mark::kDashed}}};
}

}  // namespace

std::string figures_html(const FindingFigures& f, std::size_t k) {
  std::string s = "<div class=\"figures\">";
  const auto add = [&](const char* id, const char* title, const char* how, bool there) {
    if (there) s += report::figure_html(fmt::format("{}-{}", id, k), title, how);
  };
  add("residual", "Before and after",
      "Recording minus simulation in time; shaded spans were held out of the fit, and there too the green curve must "
      "lie closer to zero.",
      !f.t_s.empty());
  add("spectrum", "Spectrum",
      "Power by frequency; where orange stands above the dashed noise, something is missing, and green must come down "
      "to it.",
      !f.frequency_hz.empty());
  add("driver", "Residual against its driver",
      "Each point is one moment; points that follow the blue law, and not a cloud or another curve, are the evidence "
      "for the name.",
      !f.driver.empty());
  add("acf", "Autocorrelation",
      "What is left after whitening; inside the dashed band it is noise, outside it something still goes on.",
      !f.autocorrelation_before.empty());
  return s + "</div>";
}

std::vector<Plot> finding_plots(const FindingFigures& f, std::size_t k) {
  const std::string residual = f.channel + ", " + f.unit;
  std::vector<Plot> plots;
  plots.push_back({fmt::format("residual-{}", k),
                   "time, s",
                   residual,
                   f.t_s,
                   {{"before", Colour::kBefore, f.residual_before}, {"after", Colour::kAfter, f.residual_after}},
                   f.held_out});
  plots.push_back(spectrum(f, fmt::format("spectrum-{}", k)));
  plots.push_back(report::in_order_of_x({fmt::format("driver-{}", k),
                                         f.driver_label,
                                         residual,
                                         f.driver,
                                         {{"residual", Colour::kBefore, f.residual_at_driver, Mark::kDots},
                                          {"law", Colour::kAccent, f.law_at_driver, Mark::kBold}}}));
  plots.push_back(autocorrelation(f, fmt::format("acf-{}", k)));
  for (std::size_t i = 0; i < f.against_each.size(); ++i) {
    const AgainstQuantity& a = f.against_each[i];
    plots.push_back(report::in_order_of_x(
        {fmt::format("each-{}-{}", k, i),
         a.label,
         residual,
         a.x,
         {{"before", Colour::kBefore, a.before, Mark::kDots}, {"after", Colour::kAfter, a.after, Mark::kDots}}}));
  }
  return plots;
}

}  // namespace stillpoint::diag
