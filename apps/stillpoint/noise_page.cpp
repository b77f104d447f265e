// The Allan deviations of a sensor and the terms that explain them, as a page.
#include <fmt/format.h>

#include "apps/stillpoint/noise_report.h"
#include "report/document.h"

namespace stillpoint::app {
namespace {

using report::Colour;
using report::Mark;
using report::Plot;

/// The axes of a sensor are read together and so have one set of averaging times.
Plot allan_plot(const SensorNoise& sensor) {
  Plot p{"allan-" + sensor.name, "averaging time, s", fmt::format("Allan deviation, {}", sensor.unit), {}, {}};
  p.log_x = p.log_y = true;
  for (const sim::AllanPoint& point : sensor.axes.front().points) p.x.push_back(point.tau_s);
  for (std::size_t k = 0; k < sensor.axes.size(); ++k) {
    const AxisNoise& axis = sensor.axes[k];
    if (axis.points.size() != p.x.size()) continue;
    std::vector<double> measured, low, high, law;
    for (const sim::AllanPoint& point : axis.points) {
      const double half = 1.96 * point.relative_error * point.deviation;
      measured.push_back(point.deviation);
      low.push_back(std::max(point.deviation - half, 0.05 * point.deviation));
      high.push_back(point.deviation + half);
      law.push_back(sim::predicted_deviation(axis.terms, point.tau_s));
    }
    const Colour colour = report::kAxisColour[k % 3];
    p.curves.push_back({axis.channel, colour, measured, Mark::kDots});
    p.curves.push_back({axis.channel + " fitted", colour, law});
    p.curves.push_back({"95 %: from", colour, low, Mark::kDashed});
    p.curves.push_back({"to", colour, high, Mark::kDashed});
  }
  return p;
}

std::string terms_row(const SensorNoise& sensor, const AxisNoise& axis) {
  std::string s = fmt::format("<tr><td>{}</td>", axis.channel);
  for (const sim::NoiseKind kind : {sim::kWhite, sim::kInstability, sim::kRandomWalk, sim::kQuantisation})
    s += axis.terms.value[kind] > 0.0 ? fmt::format("<td class=\"n\">{:.3g} ± {:.2g}</td>", axis.terms.value[kind],
                                                    1.96 * axis.terms.standard_error[kind])
                                      : fmt::format("<td class=\"n\">below {:.2g}</td>", axis.terms.upper_limit[kind]);
  return s + fmt::format("<td>{}</td></tr>", report::escaped(sensor.unit));
}

}  // namespace

std::string noise_html(const std::string& recording, const std::vector<SensorNoise>& sensors, double rate_hz,
                       double seconds) {
  std::string s = fmt::format(
      "<div class=\"verdict\"><div class=\"label\">Noise at rest</div><h1>{:.6g} s at {:.6g} Hz</h1><p "
      "class=\"small\">{}</p></div><h2>Terms</h2><p class=\"how\">With their 95 % interval, or what could be there "
      "without being seen. White noise falls with the averaging time, a random walk rises with it, bias instability is "
      "the floor between them.</p><table><tr><th>channel</th><th class=\"n\">white, /√Hz</th><th class=\"n\">bias "
      "instability</th><th class=\"n\">random walk, /√s</th><th class=\"n\">quantisation, · s</th><th>unit</th></tr>",
      seconds, rate_hz, report::escaped(recording));
  std::vector<Plot> plots;
  std::string figures;
  for (const SensorNoise& sensor : sensors) {
    for (const AxisNoise& axis : sensor.axes) s += terms_row(sensor, axis);
    plots.push_back(allan_plot(sensor));
    figures += report::figure_html(plots.back().id, "Overlapping Allan deviation: " + sensor.key,
                                   "Dots are measured, the line is the sum of the fitted terms; a click on a name "
                                   "takes its curve away, dragging zooms, a double click shows all.");
  }
  s += "</table><h2>Curves</h2><div class=\"figures\">" + figures + "</div>";
  const auto block = [](const char* title, const std::string& text) {
    return fmt::format("<h3>{}</h3><pre><code>{}</code></pre>", title, report::escaped(text));
  };
  s += "<h2>To paste</h2>" + block("Simulation", noise_simulation_block(sensors, rate_hz)) +
       block("Kalibr imu.yaml", kalibr_yaml(sensors, rate_hz));
  return report::document_html("Noise of " + recording, s, plots);
}

}  // namespace stillpoint::app
